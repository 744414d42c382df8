"""What the pictures of a mesh are drawn from, and its way into the process that draws."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from neurframe_cli.mesh.arrays import Floats, Ints
from neurframe_cli.mesh.filling.hybrid_mesh import HybridMesh

_PLACES = "places/"


@dataclass(frozen=True)
class MeshData:
    """Vertices V (n,3) and cells: quads (m,4) or hexes (m,8) in VTK order; places: points (k,3) to be marked by what
    is the matter there."""

    V: Floats
    cells: Ints
    places: Mapping[str, Floats] = field(default_factory=dict)

    def save(self, path: Path) -> None:
        """As .npz."""
        marked: dict[str, Any] = {_PLACES + what: points for what, points in self.places.items()}
        np.savez(path, V=self.V, cells=self.cells, **marked)

    @staticmethod
    def load(path: Path) -> MeshData:
        """What `save` wrote; nothing is unpickled."""
        with np.load(path, allow_pickle=False) as stored:
            names = [name for name in stored.files if name.startswith(_PLACES)]
            places = {name.removeprefix(_PLACES): stored[name] for name in names}
            return MeshData(stored["V"], stored["cells"], places)


@dataclass(frozen=True)
class HybridData:
    """A mesh of hexes, pyramids and tets."""

    mesh: HybridMesh

    def save(self, path: Path) -> None:
        """As .npz."""
        m = self.mesh
        np.savez(path, V=m.V, hexes=m.hexes, pyramids=m.pyramids, tets=m.tets)

    @staticmethod
    def load(path: Path) -> HybridData:
        """What `save` wrote; nothing is unpickled."""
        with np.load(path, allow_pickle=False) as stored:
            return HybridData(HybridMesh(*(stored[name] for name in ("V", "hexes", "pyramids", "tets"))))
