"""`python -m neurframe_cli.picture FIELD.npz NAME=PATH ...`: what draw.draw_field runs."""

from __future__ import annotations

import sys
from pathlib import Path

from neurframe_cli.picture.continuous_pictures import draw_singular_points, draw_streamlines
from neurframe_cli.picture.cross_picture import draw_crosses
from neurframe_cli.picture.field_data import FieldData
from neurframe_cli.picture.singular_picture import draw_singular_graph
from neurframe_cli.picture.volume_pictures import draw_frames, draw_tets

_DRAW = {
    "crosses": draw_crosses,
    "singular": draw_singular_graph,
    "frames": draw_frames,
    "tets": draw_tets,
    "singularities": draw_singular_points,
    "streamlines": draw_streamlines,
}


def main(field: str, targets: list[str]) -> None:
    data = FieldData.load(Path(field))
    for done, target in enumerate(targets):
        name, _, path = target.partition("=")
        print(f"progress {done / len(targets):.2f} drawing {name}", file=sys.stderr, flush=True)
        _DRAW[name](Path(path), data)


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2:])
