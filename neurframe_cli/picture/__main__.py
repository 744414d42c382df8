"""`python -m neurframe_cli.picture DATA.npz NAME=PATH ...`: what draw.draw runs."""

from __future__ import annotations

import sys
from pathlib import Path

from neurframe_cli.picture.continuous_pictures import draw_singular_points, draw_streamlines
from neurframe_cli.picture.cross_picture import draw_crosses
from neurframe_cli.picture.field_data import FieldData
from neurframe_cli.picture.filled_picture import draw_filled
from neurframe_cli.picture.mesh_data import HybridData, MeshData
from neurframe_cli.picture.mesh_pictures import (
    draw_hexes,
    draw_hexes_cut,
    draw_hexes_singular,
    draw_hexes_trouble,
    draw_quads,
)
from neurframe_cli.picture.singular_picture import draw_singular_graph
from neurframe_cli.picture.volume_pictures import draw_frames, draw_tets

_FIELD = {
    "crosses": draw_crosses,
    "singular": draw_singular_graph,
    "frames": draw_frames,
    "tets": draw_tets,
    "singularities": draw_singular_points,
    "streamlines": draw_streamlines,
}
_MESH = {
    "quads": draw_quads,
    "hexes": draw_hexes,
    "hexes_cut": draw_hexes_cut,
    "hexes_singular": draw_hexes_singular,
    "hexes_trouble": draw_hexes_trouble,
}
_HYBRID = {"filled": draw_filled}


def main(stored: str, targets: list[str]) -> None:
    for done, target in enumerate(targets):
        name, _, path = target.partition("=")
        print(f"progress {done / len(targets):.2f} drawing {name}", file=sys.stderr, flush=True)
        if name in _MESH:
            _MESH[name](Path(path), MeshData.load(Path(stored)))
        elif name in _HYBRID:
            _HYBRID[name](Path(path), HybridData.load(Path(stored)))
        else:
            _FIELD[name](Path(path), FieldData.load(Path(stored)))


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2:])
