"""Cells added to others, and taken from them, without a change of topology."""

from __future__ import annotations

import heapq
import itertools
from collections.abc import Iterable

import numpy as np

from neurframe_cli.mesh.arrays import Bools, Floats, Ints

Place = tuple[int, int, int]  # of a cell, or of one as seen from another
NEIGHBOURS: list[Place] = [
    (a, b, c) for a, b, c in itertools.product((-1, 0, 1), repeat=3) if (a, b, c) != (0, 0, 0)
]
FACES = [d for d in NEIGHBOURS if sum(map(abs, d)) == 1]


def _faces_of(direction: Place) -> list[int]:
    """The face of a cell in which it touches its neighbour in this direction, or those round the edge or corner."""
    return [
        i
        for i, face in enumerate(FACES)
        if any(f != 0 and f == d for f, d in zip(face, direction, strict=True))
    ]


TOUCHED = {d: sum(1 << i for i in _faces_of(d)) for d in NEIGHBOURS}  # bits of these faces
ALL_FACES = (1 << len(FACES)) - 1


def _connected(faces: int) -> bool:
    """Whether these faces of a cell hang together: all but two opposite ones do."""
    chosen = [np.array(face) for i, face in enumerate(FACES) if faces >> i & 1]
    opposite = len(chosen) == 2 and not (chosen[0] + chosen[1]).any()
    return len(chosen) > 0 and not opposite


IS_DISK = [_connected(faces) and _connected(ALL_FACES ^ faces) for faces in range(ALL_FACES + 1)]


class GrowingCells:
    """A set of cells of a grid whose topology stays.

    A cell can come where it meets the set in a disk: faces that hang together, those that are left, too, and with no
    edge or corner beside them.  Gluing a ball to a disk of the boundary of a manifold changes nothing, neither the
    topology nor that it is a manifold (Bertrand 1994, Simple points, topological numbers and geodesic neighborhoods in
    cubic grids, on such cells).  A cell that goes comes to the rest of space.
    """

    def __init__(self, inside: Bools) -> None:
        self.padded = np.pad(inside, 1)

    @property
    def inside(self) -> Bools:
        """Which cells of the grid (a,b,c) are in the set."""
        return np.asarray(self.padded[1:-1, 1:-1, 1:-1])

    @property
    def cells(self) -> Ints:
        """Indices (k,3)."""
        return np.argwhere(self.inside)

    def add(self, cells: Ints, order: Floats) -> int:
        """Those of the cells (k,3) that can be added, the least `order` (k,) first, and of equal ones those whose
        neighbours came first; how many these were."""
        return self._change(cells, order, True)

    def remove(self, cells: Ints, order: Floats) -> int:
        """The same for cells to be taken away."""
        return self._change(cells, order, False)

    def _change(self, cells: Ints, order: Floats, inside: bool) -> int:
        waiting: dict[Place, float] = {
            (i, j, k): rank for (i, j, k), rank in zip((cells + 1).tolist(), order.tolist(), strict=True)
        }
        queue = [(rank, n, cell) for n, (cell, rank) in enumerate(waiting.items())]
        heapq.heapify(queue)
        changed, pushed = 0, len(queue)
        while queue:
            _, _, cell = heapq.heappop(queue)
            if bool(self.padded[cell]) == inside or not self._meets_in_disk(cell, inside):
                continue
            self.padded[cell] = inside
            changed += 1
            for near in self._around(cell):
                if near in waiting and bool(self.padded[near]) != inside:
                    heapq.heappush(queue, (waiting[near], pushed, near))
                    pushed += 1
        return changed

    def _meets_in_disk(self, cell: Place, others: bool) -> bool:
        """Whether a cell meets those that are in the set, or if not `others`, those that are not, in a disk."""
        i, j, k = cell
        around = self.padded[i - 1 : i + 2, j - 1 : j + 2, k - 1 : k + 2] == others
        shared = sum(1 << n for n, (a, b, c) in enumerate(FACES) if around[a + 1, b + 1, c + 1])
        if not IS_DISK[shared]:
            return False
        return all(TOUCHED[a, b, c] & shared for a, b, c in NEIGHBOURS if around[a + 1, b + 1, c + 1])

    def _around(self, cell: Place) -> Iterable[Place]:
        i, j, k = cell
        return ((i + a, j + b, k + c) for a, b, c in NEIGHBOURS)
