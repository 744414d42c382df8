"""The 24 rotations of the cube, their multiplication table, and what each means as a holonomy round an edge."""

from __future__ import annotations

from enum import IntEnum
from itertools import permutations, product

import numpy as np

from neurframe_cli.mesh.arrays import Floats, Ints


class Turn(IntEnum):
    """Conjugacy in the group, as far as hexes tell (Nieser, Reitebuch & Polthier 2011, section 3).

    A regular edge has IDENTITY; QUARTER is a quarter turn about a frame axis (three or five hexes round the edge),
    HALF a half turn about one (two or six); COMPOUND the other 14, which no hex mesh has.
    """

    IDENTITY = 0
    QUARTER = 1
    HALF = 2
    COMPOUND = 3


def _signed_permutations() -> Floats:
    found = []
    for axes, signs in product(permutations(range(3)), product((1.0, -1.0), repeat=3)):
        g = np.zeros((3, 3))
        g[range(3), axes] = signs
        if np.linalg.det(g) > 0:
            found.append(g)
    # identity (trace 3) first, then the quarter turns (1), thirds (0) and half turns (-1)
    return np.array(sorted(found, key=lambda g: -np.trace(g)))


def nearest_element(g: Floats) -> Ints:
    """Index (...) of the element of GROUP nearest to each matrix g (..., 3, 3), of equally near ones the first.

    It has the largest inner product with g, as all elements have the same norm.
    """
    return np.asarray((np.reshape(g, (*np.shape(g)[:-2], 9)) @ GROUP.reshape(24, 9).T).argmax(-1))


def _turn(g: Floats) -> Turn:
    diagonal = np.diag(g)
    if diagonal.sum() == 3:
        return Turn.IDENTITY
    if diagonal.sum() == 1:
        return Turn.QUARTER
    return Turn.HALF if np.abs(diagonal).sum() == 3 else Turn.COMPOUND


def _axis(g: Floats) -> Floats:
    """Unit rotation axis of a quarter or half turn about a frame axis, else zero."""
    if _turn(g) == Turn.QUARTER:
        return 0.5 * np.array([g[2, 1] - g[1, 2], g[0, 2] - g[2, 0], g[1, 0] - g[0, 1]])
    return np.maximum(np.diag(g), 0.0) if _turn(g) == Turn.HALF else np.zeros(3)


# (24, 3, 3) float64, GROUP[0] the identity
GROUP = _signed_permutations()
# COMPOSE[a, b] is the index of GROUP[a] @ GROUP[b]; INVERSE[a] that of GROUP[a].T
COMPOSE = nearest_element(np.einsum("aij,bjk->abik", GROUP, GROUP))
INVERSE = nearest_element(GROUP.transpose(0, 2, 1))
# (24,) a Turn each
TURN = np.array([_turn(g) for g in GROUP], np.int64)
# (24, 3) unit rotation axes, quarter turns counter-clockwise about them; zero for identity and compounds
AXIS = np.stack([_axis(g) for g in GROUP])

for _table in (GROUP, COMPOSE, INVERSE, TURN, AXIS):
    _table.setflags(write=False)
