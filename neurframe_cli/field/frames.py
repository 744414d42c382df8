"""Frames and their band-4 coefficients: the map between them, and the projection onto the nearest frame.

A frame is a 3x3 matrix of determinant +1 whose columns are its axes; the 24 frames F g, g in octahedral_group.GROUP,
are the same cross of axes.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from neurframe_cli.field.rotations import exponential
from neurframe_cli.field.spherical_harmonics import band4, generators
from neurframe_cli.mesh.arrays import Bools, Floats, Ints

# |sum of Y4 over the three axes|^2 = 9 / (4 pi) * (3 + 6 P4(0)) = 9 / (4 pi) * 21 / 4
_UNIT = float(np.sqrt(4.0 * np.pi / 9.0 * 4.0 / 21.0))
# max |W^2 p| over frames p and unit rotation vectors W, reached for W along an axis: 16 sqrt(5 / 12)
_CURVATURE = 16.0 * float(np.sqrt(5.0 / 12.0))
# No frame is farther than this from the start grid (8.56 degrees found over 20,000 random frames)
_COVERING_RAD = float(np.radians(9.0))
# Grid frames this close to a maximum (<p, p'>; 17 degrees) lead to the same one
_SAME_BASIN = 0.75
# A grid frame is no local maximum of the grid if one of so many nearest ones is better
_NEIGHBORS = 14
_GRADIENT_TOLERANCE = 1e-11
_MAX_STEPS = 60
_CHUNK = 1024


@dataclass(frozen=True)
class Projection:
    """Nearest frames of coefficient vectors.

    frames (n,3,3), columns are axes; distance (n,) = |q - frame_to_band4(frame)|; converged (n,): the frame is a
    local minimum of the distance (gradient and second derivatives checked).
    """

    frames: Floats
    distance: Floats
    converged: Bools


def frame_to_band4(R: Floats) -> Floats:
    """Unit coefficient vectors of frames: R (..., 3, 3) with axes as columns -> (..., 9).

    The band-4 part of sum_a (v_a.s)^4, normalised; by the addition theorem that is the sum of Y4(v_a).  It is the
    paper's F(s) up to a constant and a negative factor: its maxima are the axes, as the target +sqrt(7/12) asks.
    """
    return np.asarray(_UNIT * band4(np.swapaxes(R, -1, -2)).sum(axis=-2))


def nearest_frames(q: Floats) -> Projection:
    """The frame whose coefficients are nearest to each q (n,9), which need not be a unit vector.

    The linearised projection of Ray & Sokolov (2016) solves min |q - (p + [Lx p, Ly p, Lz p] w)| and turns p by w;
    as |L_i p|^2 = 20/3 on every frame, that is a gradient step of fixed length.  Here the same linearisation is
    carried to second order (Newton on <q, p>, a gradient step where Newton does not ascend) and started from
    the best of a grid of 697 frames, and from every other local maximum of the grid that could still win: all
    frames being within 9 degrees of the grid, a maximum is at most |q| 16 sqrt(5/12) / 2 * 9deg^2 above its grid
    frame.  A q of zeros or not finite has no nearest frame: it gets some frame and is not converged.
    """
    q = np.asarray(q, np.float64).reshape(-1, 9)
    finite: Bools = np.asarray(np.isfinite(q).all(axis=1))
    safe = np.where(finite[:, None], q, 0.0)
    frames, converged = np.empty((len(q), 3, 3)), np.empty(len(q), bool)
    for begin in range(0, len(q), _CHUNK):
        part = slice(begin, begin + _CHUNK)
        frames[part], converged[part] = _best_frames(safe[part])
    frames[~finite] = np.eye(3)
    distance = np.linalg.norm(q - frame_to_band4(frames), axis=1)
    return Projection(frames, distance, converged & finite)


@cache
def _start_grid() -> tuple[Floats, Floats]:
    """Frames (697,3,3) and coefficients (697,9): a grid in Rodrigues vectors over the truncated cube.

    The Rodrigues vectors of the rotations nearer to the identity than to any other element of the cube group are
    |r_i| <= tan(pi/8), |r_1| + |r_2| + |r_3| <= 1.
    """
    steps = np.tan(np.pi / 8) * ((np.arange(9) + 0.5) / 4.5 - 1.0)
    r = np.stack(np.meshgrid(steps, steps, steps, indexing="ij"), axis=-1).reshape(-1, 3)
    r = r[np.abs(r).sum(axis=1) <= 1.0]
    length = np.linalg.norm(r, axis=1, keepdims=True)
    angle_over_length = np.divide(2 * np.arctan(length), length, out=np.zeros_like(length), where=length > 0)
    frames = exponential(r * angle_over_length)
    return frames, frame_to_band4(frames)


@cache
def _grid_neighbors() -> Ints:
    """The nearest grid frames of each grid frame, (697, _NEIGHBORS)."""
    _, grid = _start_grid()
    return np.asarray(np.argsort(-grid @ grid.T, axis=1)[:, 1 : _NEIGHBORS + 1])


def _row_products(a: Floats, b: Floats) -> Floats:
    """a @ b.T for a (n,k) and b (m,k), where no row of the result depends on the other rows.

    A BLAS adds in an order that depends on the number of rows and of threads.  The last bits then decide between
    starts that are equally good, and a field's frames change with the batch and with the machine's load.
    """
    result = a[:, :1] * b[:, 0]
    for i in range(1, a.shape[1]):
        result += a[:, i : i + 1] * b[:, i]
    return np.asarray(result)


def _best_frames(q: Floats) -> tuple[Floats, Bools]:
    """Global maximisers of <q, p> over frames p, one chunk: (n,3,3) and whether each is a local maximum."""
    grid_frames, grid = _start_grid()
    scores = _row_products(q, grid)
    frames, p, converged = _ascend(q, grid_frames[scores.argmax(axis=1)])
    value = np.einsum("ni,ni->n", q, p)
    row, start = _rivals(scores, value, p, np.linalg.norm(q, axis=1))
    rival, rival_p, rival_converged = _ascend(q[row], grid_frames[start])
    reached = np.einsum("ni,ni->n", q[row], rival_p)
    # in ascending order, so that of several better rivals of a row the best is written last
    order = np.argsort(reached, kind="stable")
    order = order[reached[order] > value[row[order]]]
    frames[row[order]], converged[row[order]] = rival[order], rival_converged[order]
    return frames, converged


def _rivals(scores: Floats, value: Floats, p: Floats, norm: Floats) -> tuple[Ints, Ints]:
    """Pairs (row, grid frame) from where a maximum above `value` could be reached, outside the basin of p."""
    _, grid = _start_grid()
    slack = 0.5 * _CURVATURE * _COVERING_RAD**2 * norm
    rows = np.flatnonzero(
        np.where(_row_products(p, grid) > _SAME_BASIN, -np.inf, scores).max(axis=1) > value - slack
    )
    close, bound = _row_products(p[rows], grid) > _SAME_BASIN, (value - slack)[rows]
    row, start = np.nonzero((scores[rows] > bound[:, None]) & ~close)
    own = scores[rows[row], start]
    peak = (own[:, None] >= scores[rows[row][:, None], _grid_neighbors()[start]]).all(axis=1)
    return rows[row[peak]], start[peak]


@cache
def _derivative_table() -> Floats:
    """(9,9,9): Lx, Ly, Lz and the symmetric products of xx, yy, zz, yz, xz, xy."""
    L = generators()
    pairs = [(0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1)]
    return np.stack([*L, *(0.5 * (L[i] @ L[j] + L[j] @ L[i]) for i, j in pairs)])


def _derivatives(q: Floats, p: Floats) -> tuple[Floats, Floats]:
    """Gradient (n,3) and minus the Hessian (n,3,3) of w -> <q, exp(w.L) p> at w = 0."""
    turned = _row_products(p, _derivative_table().reshape(81, 9)).reshape(-1, 9, 9)
    d = np.einsum("nki,ni->nk", turned, q)
    return d[:, :3], -d[:, [3, 8, 7, 8, 4, 6, 7, 6, 5]].reshape(-1, 3, 3)


def _is_positive(A: Floats, margin: Floats) -> Bools:
    """Whether A + margin I, symmetric (n,3,3), is positive definite, by its leading minors."""
    A = A + margin[:, None, None] * np.eye(3)
    second = A[:, 0, 0] * A[:, 1, 1] - A[:, 0, 1] ** 2
    return np.asarray((A[:, 0, 0] > 0) & (second > 0) & (np.linalg.det(A) > 0))


def _newton_step(gradient: Floats, curvature: Floats, scale: Floats) -> Floats:
    """Newton steps (n,3) of at most 0.3 rad; where the curvature is not positive, by its absolute eigenvalues."""
    step = np.empty_like(gradient)
    positive = _is_positive(curvature, -1e-7 * scale)
    step[positive] = np.linalg.solve(curvature[positive], gradient[positive, :, None])[..., 0]
    eigenvalues, axes = np.linalg.eigh(curvature[~positive])
    size = np.maximum(np.abs(eigenvalues), 0.1 * scale[~positive, None])
    along = np.einsum("nij,ni->nj", axes, gradient[~positive]) / size
    step[~positive] = np.einsum("nij,nj->ni", axes, along)
    length = np.linalg.norm(step, axis=1, keepdims=True)
    return np.asarray(step * np.minimum(1.0, 0.3 / np.maximum(length, 0.3)))


def _ascend(q: Floats, R: Floats) -> tuple[Floats, Floats, Bools]:
    """From frames R uphill on <q, p>: frames, their coefficients p, and whether each is a local maximum."""
    R, p = R.copy(), frame_to_band4(R)
    maximal = np.zeros(len(q), bool)
    norm = np.linalg.norm(q, axis=1)
    left: Ints = np.arange(len(q))
    for _ in range(_MAX_STEPS):
        gradient, curvature = _derivatives(q[left], p[left])
        moving = np.linalg.norm(gradient, axis=1) > _GRADIENT_TOLERANCE * norm[left]
        maximal[left] = ~moving & _is_positive(curvature, 1e-6 * np.maximum(norm[left], 1e-300))
        left, gradient, curvature = left[moving], gradient[moving], curvature[moving]
        if not len(left):
            break
        R[left], p[left] = _step(q[left], R[left], p[left], gradient, curvature, norm[left])
    return R, p, maximal


def _step(
    q: Floats, R: Floats, p: Floats, gradient: Floats, curvature: Floats, norm: Floats
) -> tuple[Floats, Floats]:
    """One Newton step, halved twice if need be, else the gradient step 1 / _CURVATURE, which always ascends."""
    goal = np.einsum("ni,ni->n", q, p) - 1e-14 * norm
    newton = _newton_step(gradient, curvature, norm)
    steepest = gradient / (_CURVATURE * norm[:, None])
    trial, trial_p = np.empty_like(R), np.empty_like(p)
    todo = np.arange(len(q))
    for w in (newton, 0.5 * newton, 0.25 * newton, steepest):
        trial[todo] = exponential(w[todo]) @ R[todo]
        trial_p[todo] = frame_to_band4(trial[todo])
        todo = todo[np.einsum("ni,ni->n", q[todo], trial_p[todo]) < goal[todo]]
        if not len(todo):
            break
    return trial, trial_p
