"""The singular graph inside the translucent body."""

from __future__ import annotations

from pathlib import Path

from neurframe_cli.picture.field_data import FieldData
from neurframe_cli.picture.scene import FEATURE_COLOR, Scene

# quarters, as in SingularEdges -> colour and name
KINDS = {
    1: ("#d62728", "+1/4, three hexes"),
    -1: ("#1f5fd0", "-1/4, five hexes"),
    2: ("#ee8a1d", "half turn"),
    0: ("#111111", "compound, not meshable"),
}


def draw_singular_graph(path: Path, data: FieldData) -> None:
    """PNG of the singular edges as tubes, coloured by kind, in the outline of the body."""
    scene = Scene(data.surface.V)
    scene.silhouette(data.surface.V, data.surface.F)
    scene.lines(data.tets.V, data.feature_edges, color=FEATURE_COLOR, width=1.2)
    for quarters, (color, name) in KINDS.items():
        edges = data.singular_edges[data.quarters == quarters]
        scene.lines(data.tets.V, edges, color=color, width=4.0, tubes=True)
        if len(edges):
            scene.label(color, f"{name}: {len(edges)}")
    scene.surface(data.surface.V, data.surface.F, opacity=0.12, color="#8fa6bf")
    if not len(data.singular_edges):
        scene.label("#777777", "no singular edges")
    scene.save(path)
