"""The tables against matrix arithmetic and against the known class sizes of the rotation group of the cube."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from neurframe_cli.field.octahedral_group import AXIS, COMPOSE, GROUP, INVERSE, TURN, Turn


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


def test_axes_turn_quarters_counter_clockwise_and_are_fixed():
    for g, axis in zip(GROUP[TURN == Turn.QUARTER], AXIS[TURN == Turn.QUARTER], strict=True):
        assert axis == pytest.approx(Rotation.from_matrix(g).as_rotvec() / (np.pi / 2), abs=1e-12)
    assert (np.einsum("gij,gj->gi", GROUP, AXIS) == AXIS).all()
    has_axis = (TURN == Turn.QUARTER) | (TURN == Turn.HALF)
    assert (np.linalg.norm(AXIS, axis=1) == has_axis).all()
