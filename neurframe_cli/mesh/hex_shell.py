"""The boundary of a hex mesh."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from neurframe_cli.mesh.arrays import Bools, Ints

# faces of a hexahedron in VTK order, outward
HEX_FACES = np.array([[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]])
HEX_EDGES = np.array(
    [[0, 1], [1, 2], [2, 3], [3, 0], [4, 5], [5, 6], [6, 7], [7, 4], [0, 4], [1, 5], [2, 6], [3, 7]]
)


@dataclass(frozen=True)
class HexShell:
    """Faces of exactly one hex: quads (f,4) outward; faces (f,): 6 times the hex plus the row of HEX_FACES."""

    quads: Ints
    faces: Ints

    @property
    def owner(self) -> Ints:
        """The hex (f,) that each belongs to."""
        return self.faces // len(HEX_FACES)


def hex_shell(H: Ints, kept: Bools | None = None) -> HexShell:
    """The shell of hexes H (n,8) in VTK order, or of those `kept` (n,)."""
    numbers = np.arange(len(H)) if kept is None else np.flatnonzero(kept)
    quads = H[numbers][:, HEX_FACES].reshape(-1, 4)
    _, first, use = np.unique(np.sort(quads, axis=1), axis=0, return_index=True, return_counts=True)
    single = np.sort(first[use == 1])
    return HexShell(quads[single], 6 * numbers[single // 6] + single % 6)
