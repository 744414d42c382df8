"""Pictures as artifacts."""

from __future__ import annotations

from collections.abc import Mapping

from neurframe_cli.errors import StageError, TimedOut
from neurframe_cli.picture.draw import draw
from neurframe_cli.picture.field_data import FieldData
from neurframe_cli.picture.mesh_data import HybridData, MeshData
from neurframe_cli.pipeline.atomic import scratch_folder
from neurframe_cli.pipeline.runner import StageContext


def draw_or_warn(
    context: StageContext, pictures: Mapping[str, str], data: FieldData | MeshData | HybridData
) -> None:
    """Pictures by name -> file in the workspace, or a warning where this machine cannot draw: no result needs them."""
    with scratch_folder(context.workspace.folder) as scratch:
        drawn = {name: scratch / file for name, file in pictures.items()}
        try:
            draw(drawn, data)
        except (StageError, TimedOut, OSError) as error:
            context.warn(f"no pictures: {error}")
            return
        for path in drawn.values():
            path.replace(context.workspace / path.name)
