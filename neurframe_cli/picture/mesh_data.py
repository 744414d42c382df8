"""What the pictures of a quad or hex mesh are drawn from, and its way into the process that draws."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from neurframe_cli.mesh.arrays import Floats, Ints


@dataclass(frozen=True)
class MeshData:
    """Vertices V (n,3) and cells: quads (m,4) or hexes (m,8) in VTK order."""

    V: Floats
    cells: Ints

    def save(self, path: Path) -> None:
        """As .npz."""
        np.savez(path, V=self.V, cells=self.cells)

    @staticmethod
    def load(path: Path) -> MeshData:
        """What `save` wrote; nothing is unpickled."""
        with np.load(path, allow_pickle=False) as stored:
            return MeshData(stored["V"], stored["cells"])
