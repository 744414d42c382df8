"""What the pictures of a field are drawn from, and its way into the process that draws."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from neurframe_cli.mesh.arrays import Floats, Ints, Surface, TetMesh


@dataclass(frozen=True)
class FieldData:
    """A field on tets and on a surface.

    feature_edges (k,2): vertex pairs of the tets.  What a picture needs besides: crosses (m,2,3) on the surface;
    frames (q,3,3) on the tets, axes as columns; singular_edges (s,2) and quarters (s,) as in SingularEdges;
    singular_points (p,3) of the continuous field with point_quarters (p,), and streamlines, one after the other,
    streamline i being streamline_points[streamline_offsets[i]:streamline_offsets[i+1]].
    """

    surface: Surface
    tets: TetMesh
    feature_edges: Ints = field(default_factory=lambda: np.zeros((0, 2), np.int64))
    crosses: Floats = field(default_factory=lambda: np.zeros((0, 2, 3)))
    frames: Floats = field(default_factory=lambda: np.zeros((0, 3, 3)))
    singular_edges: Ints = field(default_factory=lambda: np.zeros((0, 2), np.int64))
    quarters: Ints = field(default_factory=lambda: np.zeros(0, np.int64))
    singular_points: Floats = field(default_factory=lambda: np.zeros((0, 3)))
    point_quarters: Ints = field(default_factory=lambda: np.zeros(0, np.int64))
    streamline_points: Floats = field(default_factory=lambda: np.zeros((0, 3)))
    streamline_offsets: Ints = field(default_factory=lambda: np.zeros(1, np.int64))

    def save(self, path: Path) -> None:
        """As .npz."""
        arrays: dict[str, Any] = {
            name: value for name, value in vars(self).items() if name not in ("surface", "tets")
        }
        arrays |= {"V": self.surface.V, "F": self.surface.F, "tet_V": self.tets.V, "T": self.tets.T}
        np.savez(path, **arrays)

    @staticmethod
    def load(path: Path) -> FieldData:
        """What `save` wrote; nothing is unpickled."""
        with np.load(path, allow_pickle=False) as stored:
            arrays = dict(stored)
        surface = Surface(arrays.pop("V"), arrays.pop("F"))
        tets = TetMesh(arrays.pop("tet_V"), arrays.pop("T"))
        return FieldData(surface=surface, tets=tets, **arrays)
