"""Heat in a cylinder: a hex mesh from neurframe in a finite-element program (scikit-fem), against the closed form.

    neurframe run samples/cylinder.stl --hex --scale 20 -w cylinder.neurframe
    python docs/examples/heat_in_a_cylinder.py cylinder.neurframe/hex.vtk

The rod is heated evenly inside (source q), cooled to zero on its mantle, insulated at its ends:
-ΔT = q, T = 0 at r = R, so T = q (R² - r²) / 4 at every height.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass

import meshio
import numpy as np
from skfem import Basis, ElementHex1, LinearForm, MeshHex, condense, solve
from skfem.models.poisson import laplace

# scikit-fem begins a hex at (1,1,1): then (1,1,0) (1,0,1) (0,1,1) (1,0,0) (0,1,0) (0,0,1) (0,0,0)
FROM_VTK = [6, 2, 5, 7, 1, 3, 4, 0]


@dataclass(frozen=True)
class Comparison:
    """hexes; centre, exact_centre: temperature on the axis; worst: largest error over exact_centre."""

    hexes: int
    centre: float
    exact_centre: float
    worst: float


def compare(path: str, source: float = 1.0) -> Comparison:
    """Solves on the hexes of a file whose axis is z, and compares at all vertices."""
    mesh = read_hexes(path)
    basis = Basis(mesh, ElementHex1())
    middle = (mesh.p[:2].max(axis=1) + mesh.p[:2].min(axis=1)) / 2
    r = np.linalg.norm(mesh.p[:2] - middle[:, None], axis=0)
    radius = r.max()
    low, high = mesh.p[2].min(), mesh.p[2].max()
    sides = mesh.facets_satisfying(lambda x: (x[2] > low) & (x[2] < high), boundaries_only=True)
    mantle = basis.get_dofs(sides)
    load = LinearForm(lambda v, _: source * v).assemble(basis)
    temperature = solve(*condense(laplace.assemble(basis), load, D=mantle))
    exact = source * (radius**2 - r**2) / 4
    peak = source * radius**2 / 4
    return Comparison(
        mesh.t.shape[1], float(temperature.max()), peak, float(abs(temperature - exact).max() / peak)
    )


def read_hexes(path: str) -> MeshHex:
    """The hexahedra of a file in scikit-fem's corner order."""
    file = meshio.read(path)
    corners = file.cells_dict["hexahedron"][:, FROM_VTK]
    return MeshHex(np.ascontiguousarray(file.points.T), np.ascontiguousarray(corners.T))


if __name__ == "__main__":
    found = compare(sys.argv[1])
    print(f"{found.hexes} hexes: {found.centre:.4f} on the axis, exactly {found.exact_centre:.4f}; "
          f"worst error {found.worst:.2%}")  # fmt: skip
