"""Shape and size of the corners of quads and hexes as one energy, regularised so that it can untangle.

At each corner, S has the edge vectors divided by their target lengths as columns, D = det S, d its dimension and
χ(D) = (D + sqrt(D² + ε²)) / 2:

    φ = (1 - λ) tr(SᵀS) / (d χ^(2/d))  +  λ (1 + D²) / (2 χ)         (Garanzha et al. 2021, equation 2)

Both parts are 1 for the target corner and more otherwise; with ε = 0 the energy is infinite where D <= 0.  The loops
over the corners are those of native/smooth, whose result does not depend on the number of threads.
"""

from __future__ import annotations

import ctypes
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import neurframe_cli
from neurframe_cli.errors import StageError
from neurframe_cli.mesh.arrays import Floats, Ints
from neurframe_cli.process.threads import usable_threads

LIBRARY = Path(neurframe_cli.__file__).parent / "bin" / "libneurframe_smooth.so"
_Address, _Number, _Real = ctypes.c_void_p, ctypes.c_int64, ctypes.c_double


@dataclass(frozen=True)
class EnergyWeights:
    """size: λ above; power: exponent of φ in the sum, larger to favour the worst corner; epsilon: ε above."""

    size: float = 0.1
    power: float = 1.0
    epsilon: float = 0.0


class _Corners(ctypes.Structure):
    """NeurframeCorners of native/smooth/corner_energy.hpp."""

    _fields_ = [
        ("vertex_count", _Number),
        ("count", _Number),
        ("dimension", _Number),
        ("vertices", _Address),
        ("inverse", _Address),
        ("first_use", _Address),
        ("uses", _Address),
    ]


class _Weights(ctypes.Structure):
    """NeurframeWeights of native/smooth/corner_energy.hpp."""

    _fields_ = [("size", _Real), ("power", _Real), ("epsilon", _Real)]


class CornerEnergy:
    """Sum of φ^power / power over the corners of a mesh with n vertices.

    origin (m,) vertex of each corner; neighbours (m,d) the ends of its d edges, right-handed; lengths (m,d) targets.
    Positions x are (n,3), normals (m,3) are unit, needed for quads, and None for hexes.
    """

    def __init__(self, n: int, origin: Ints, neighbours: Ints, lengths: Floats) -> None:
        self.corners, dimension = neighbours.shape
        self._vertices: Ints = np.column_stack([origin, neighbours]).astype(np.int64)
        self._inverse: Floats = np.ascontiguousarray(1.0 / lengths, np.float64)
        self._uses: Ints = np.argsort(self._vertices, axis=None, kind="stable").astype(np.int64)
        use_count = np.bincount(self._vertices.ravel(), minlength=n)
        assert len(use_count) == n, "corners of vertices that are not there"
        self._first_use: Ints = np.concatenate([[0], np.cumsum(use_count)]).astype(np.int64)
        pointers = map(_address, (self._vertices, self._inverse, self._first_use, self._uses))
        self._struct = _Corners(n, self.corners, dimension, *pointers)
        self._parts: Floats = np.empty((*self._vertices.shape, 3))
        squares = np.column_stack([(self._inverse**2).sum(axis=1), self._inverse**2])
        stiffness = np.bincount(self._vertices.ravel(), squares.ravel(), minlength=n).reshape(-1, 1)
        self.scale: Floats = 1.0 / np.maximum(stiffness, stiffness.max() * 1e-9)

    @property
    def lengths(self) -> Floats:
        """The target lengths (m,d)."""
        return np.asarray(1.0 / self._inverse)

    def evaluate(self, x: Floats, normals: Floats | None, weights: EnergyWeights) -> tuple[float, Floats]:
        """Energy and its gradient (n,3) at x; inf where a corner is inverted and ε = 0, or past float range."""
        places, sides = self._checked(x), self._checked_normals(normals, self.corners)
        gradient = np.zeros_like(places)
        value = _library().neurframe_corner_energy(
            ctypes.byref(self._struct),
            _address(places),
            _address(sides),
            ctypes.byref(_Weights(weights.size, weights.power, weights.epsilon)),
            usable_threads(),
            _address(self._parts),
            _address(gradient),
        )
        return value, gradient

    def least_determinant(self, x: Floats, normals: Floats | None) -> float:
        """The least D over all corners."""
        places, sides = self._checked(x), self._checked_normals(normals, self.corners)
        arguments = ctypes.byref(self._struct), _address(places), _address(sides), usable_threads()
        return float(_library().neurframe_least_determinant(*arguments))

    def scaled_jacobians(self, x: Floats, normals: Floats | None, corners: Ints) -> Floats:
        """Scaled Jacobian (k,) at `corners` (k,) with normals (k,3): D over the product of the columns' lengths."""
        places, chosen = self._checked(x), np.ascontiguousarray(corners, np.int64)
        sides = self._checked_normals(normals, len(chosen))
        quality = np.empty(len(chosen))
        _library().neurframe_scaled_jacobians(
            ctypes.byref(self._struct),
            _address(places),
            _address(sides),
            _address(chosen),
            len(chosen),
            usable_threads(),
            _address(quality),
        )
        return quality

    def _checked(self, x: Floats) -> Floats:
        assert x.shape == (self._struct.vertex_count, 3), "positions of other vertices"
        return np.ascontiguousarray(x, np.float64)

    def _checked_normals(self, normals: Floats | None, count: int) -> Floats | None:
        assert (normals is None) == (self._struct.dimension == 3), "normals are for quads"
        assert normals is None or normals.shape == (count, 3), "normals of other corners"
        return None if normals is None else np.ascontiguousarray(normals, np.float64)


def _address(array: NDArray[Any] | None) -> int | None:
    return None if array is None else array.ctypes.data


@cache
def _library() -> ctypes.CDLL:
    return load_library()


def load_library() -> ctypes.CDLL:
    """The loops of native/smooth; raises StageError where they were not built."""
    try:
        library = ctypes.CDLL(str(LIBRARY))
    except OSError as error:
        hint = "pip install neurframe builds it"
        raise StageError(f"the library {LIBRARY.name} cannot be loaded ({error})", hint=hint) from error
    library.neurframe_corner_energy.restype = _Real
    library.neurframe_corner_energy.argtypes = [_Address] * 4 + [ctypes.c_int] + [_Address] * 2
    library.neurframe_least_determinant.restype = _Real
    library.neurframe_least_determinant.argtypes = [_Address] * 3 + [ctypes.c_int]
    library.neurframe_scaled_jacobians.restype = None
    library.neurframe_scaled_jacobians.argtypes = [_Address] * 4 + [_Number, ctypes.c_int, _Address]
    return library
