"""Paths for many curves that share no vertex.

Where two curves of the input are closer to each other than the edges of the mesh are long, their cheapest paths meet.
As wires on a chip they are laid by negotiation (McMurchie and Ebeling 1995, PathFinder: a negotiation-based
performance-driven router for FPGAs): every curve takes its own cheapest path, vertices that several want become dearer
round by round, the more so the longer they are contended for, until the curves that can do without them have left.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from neurframe_cli.mesh.arrays import Bools, Ints
from neurframe_cli.mesh.optimize.curve_paths import MeshGraph, Stretch

ROUNDS = 12
SHARED, CONTENDED = 0.2, 0.1  # what a vertex costs in each round for every other path there, and ever after


def disjoint_paths(
    graph: MeshGraph, stretches: list[Stretch], stops: Callable[[int], list[int]]
) -> list[Ints | None]:
    """For each stretch the path (k,) through its stops, None where there is none; the vertices of all paths are no
    longer free then.  Vertices that are not free at first may be shared by paths that end there.

    What is contended for to the end goes to the longer curve.
    """
    common = ~graph.free
    paths = [stretch.path_through(stops(i)) for i, stretch in enumerate(stretches)]
    contended = _negotiate(graph, stretches, stops, paths, common)
    order = sorted(range(len(paths)), key=lambda i: (i in contended, -stretches[i].knots[-1]))
    for i in order:
        path = paths[i]
        if path is not None and not (graph.free | common)[path].all():
            path = paths[i] = stretches[i].path_through(stops(i))
        if path is not None:
            graph.free[path] = False
    return paths


def _negotiate(
    graph: MeshGraph,
    stretches: list[Stretch],
    stops: Callable[[int], list[int]],
    paths: list[Ints | None],
    common: Bools,
) -> set[int]:
    """Lay the paths anew that share a vertex which is not common to all, until none does or the rounds are over; which
    of them still do."""
    uses, past = np.zeros(len(graph.X)), np.zeros(len(graph.X))
    for path in paths:
        if path is not None:
            uses[np.unique(path)] += 1

    def contended() -> dict[int, Ints]:
        crowded = (uses > 1) & ~common
        return {i: path for i, path in enumerate(paths) if path is not None and crowded[path].any()}

    for number in range(ROUNDS):
        rivals = contended()
        if not rivals:
            break
        past += (uses > 1) & ~common
        for i, path in rivals.items():
            uses[np.unique(path)] -= 1
            graph.dear = np.where(common, 0.0, SHARED * (number + 1) * uses + CONTENDED * past)
            found = stretches[i].path_through(stops(i))
            chosen = path if found is None else found
            uses[np.unique(chosen)] += 1
            paths[i] = chosen
    graph.dear = np.zeros(len(graph.X))
    return set(contended())
