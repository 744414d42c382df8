"""The process in which Netgen fills a closed surface with tets: it may crash or hang here, and only here.

    python -m neurframe_cli.stages.netgen_worker INPUT.npz OUTPUT.npz

INPUT holds V (n,3), F (m,3) outward and edge_length; OUTPUT gets V, which begins with those of INPUT, and T.
"""

from __future__ import annotations

import sys
from pathlib import Path


def main(argv: list[str]) -> int:
    source, target = argv
    import numpy as np
    from netgen.meshing import Element2D, FaceDescriptor, Mesh, MeshingParameters, MeshPoint, Pnt

    with np.load(source, allow_pickle=False) as arrays:
        V, F, edge_length = arrays["V"], arrays["F"], float(arrays["edge_length"])
    mesh = Mesh(3)
    inside = mesh.Add(FaceDescriptor(surfnr=1, domin=1, bc=1))
    points = [mesh.Add(MeshPoint(Pnt(*point))) for point in V.tolist()]
    for corners in F.tolist():
        mesh.Add(Element2D(inside, [points[v] for v in corners]))
    mesh.GenerateVolumeMesh(MeshingParameters(maxh=edge_length))
    made = np.array([point.p for point in mesh.Points()], np.float64)
    tets = np.array([[v.nr - 1 for v in cell.vertices] for cell in mesh.Elements3D()], np.int64)
    partial = Path(target).with_suffix(".partial.npz")
    np.savez(partial, V=made, T=tets.reshape(-1, 4))
    partial.rename(target)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
