"""The tables against matrix arithmetic and against the known class sizes of the rotation group of the cube."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from neurframe_cli.field.octahedral_group import COMPOSE, GROUP, INVERSE, SPIN, TURN, Turn


def test_elements_are_24_distinct_rotations_and_identity_is_first():
    assert GROUP.shape == (24, 3, 3)
    assert len({g.tobytes() for g in GROUP}) == 24
    assert pytest.approx(1.0) == np.linalg.det(GROUP)
    assert (GROUP[0] == np.eye(3)).all()


def test_tables_agree_with_matrix_products():
    assert (GROUP[COMPOSE] == np.einsum("aij,bjk->abik", GROUP, GROUP)).all()
    assert (GROUP[INVERSE] == GROUP.transpose(0, 2, 1)).all()


def test_classes_have_the_sizes_of_the_cube_group_and_are_invariant_under_conjugation():
    assert {kind: int((kind == TURN).sum()) for kind in Turn} == {
        Turn.IDENTITY: 1,
        Turn.QUARTER: 6,
        Turn.HALF: 3,
        Turn.COMPOUND: 14,
    }
    conjugate = COMPOSE[COMPOSE, INVERSE[:, None]]  # (a b) a^-1
    assert (TURN[conjugate] == TURN[None, :]).all()


def test_spin_is_the_axis_of_quarter_turns():
    for g, spin in zip(GROUP[TURN == Turn.QUARTER], SPIN[TURN == Turn.QUARTER], strict=True):
        rotvec = Rotation.from_matrix(g).as_rotvec()
        assert spin / 2 == pytest.approx(rotvec / (np.pi / 2), abs=1e-12)
        assert np.abs(spin).sum() == 2
