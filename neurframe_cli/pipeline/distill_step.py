"""distill on files: field.safetensors, map.hexex -> map-field.safetensors."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from neurframe_cli.field.field_file import field_to_bytes, read_field
from neurframe_cli.mesh.read_hex_map import read_hex_map
from neurframe_cli.pipeline.atomic import atomic_path
from neurframe_cli.pipeline.hex_step import HEX
from neurframe_cli.pipeline.manifest import read_manifest
from neurframe_cli.pipeline.runner import StageContext, Step
from neurframe_cli.pipeline.train_step import FIELD
from neurframe_cli.pipeline.workspace import Workspace
from neurframe_cli.stages.distill_map import DistillOptions, distill_map

MAP_FIELD = "map-field.safetensors"
_UNKEYED = ("threads",)


def distill_step(workspace: Workspace, options: DistillOptions) -> Step:
    """The stage bound to its files."""
    inputs = {FIELD: workspace.require(FIELD, "train"), HEX.map_name: workspace.require(HEX.map_name, "hex")}
    values = asdict(options)

    def work(context: StageContext) -> dict[str, Any]:
        hexes = read_manifest(context.workspace.folder).stages.get("hex")
        if hexes is not None and "grid" in hexes.report:
            context.warn("the hexes are of a regular grid, not of map.hexex, whose field this is")
        field = read_field(inputs[FIELD])
        made = distill_map(field, read_hex_map(inputs[HEX.map_name]), options, context.progress)
        with atomic_path(context.workspace / MAP_FIELD) as path:
            path.write_bytes(field_to_bytes(made.field, about={"map": made.report["after"]}))
        return made.report

    keyed = {name: value for name, value in values.items() if name not in _UNKEYED}
    unkeyed = {name: values[name] for name in _UNKEYED}
    packages = ("torch", "safetensors", "numpy")
    return Step("distill", 1, inputs, (MAP_FIELD,), keyed, work, unkeyed_options=unkeyed, packages=packages)
