"""Layers as a scene of vtk.js, and vtk.js itself from the package trame-vtk (extra `report`)."""

from __future__ import annotations

import base64
import hashlib
import importlib.metadata
import importlib.util
import io
import json
import re
import zipfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from neurframe_cli.report.layers import Layer, ViewFrame, rgb

INSTALL_HINT = "pip install 'neurframe[report]'"
_VIEWER = "tools/static_viewer.html"  # in trame_vtk: vtk.js and window.OfflineLocalView in one script
_FAVICON = "https://kitware.github.io/vtk-js/icon/favicon-"
_CELL_FIELD = 4  # vtkMapper::ScalarMode
_EDGE_COLOR = "#39424d"


def viewer_script() -> str | None:
    """The JavaScript of vtk.js with its loader, None where trame-vtk is not installed or no longer has it."""
    spec = importlib.util.find_spec("trame_vtk")
    folders = [] if spec is None else list(spec.submodule_search_locations or [])
    for folder in folders:
        page = Path(folder) / _VIEWER
        if page.is_file():
            found = re.search(
                r'<script type="module">(.*?)</script>', page.read_text(encoding="utf-8"), re.DOTALL
            )
            if found is not None and "window.OfflineLocalView" in found[1]:
                # it would give the page an icon from its own site
                return found[1].replace(_FAVICON, "data:,")
    return None


def viewer_license() -> str:
    """The licence of what viewer_script returns, which goes wherever that goes; empty where it is not installed."""
    try:
        return importlib.metadata.distribution("trame-vtk").read_text("licenses/LICENSE") or ""
    except importlib.metadata.PackageNotFoundError:
        return ""


def scene_archive(layers: Sequence[Layer], frame: ViewFrame) -> str:
    """The scene as the viewer loads it: index.json (state and arrays of vtk.js) in a zip, in base 64."""
    arrays: dict[str, dict[str, str]] = {}
    actors = [_actor(number, layer, frame, arrays) for number, layer in enumerate(layers)]
    document = {"scene": _window(actors), "hashes": arrays}
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w", zipfile.ZIP_DEFLATED) as archive:
        # a fixed date, so that the same scene gives the same bytes
        entry = zipfile.ZipInfo("index.json", (1980, 1, 1, 0, 0, 0))
        entry.compress_type = zipfile.ZIP_DEFLATED
        archive.writestr(entry, json.dumps(document, allow_nan=False), compresslevel=6)
    return base64.b64encode(content.getvalue()).decode()


def _window(actors: list[dict[str, Any]]) -> dict[str, Any]:
    camera = _object("vtkCamera", "camera", "renderer", {"parallelProjection": True})
    renderer = _object(
        "vtkRenderer",
        "renderer",
        "window",
        {
            "background": [1, 1, 1],
            "twoSidedLighting": True,
            "lightFollowCamera": True,
            "layer": 0,
            "interactive": True,
        },
        [("setActiveCamera", camera), *(("addViewProp", actor) for actor in actors)],
    )
    return _object("vtkRenderWindow", "window", "0x0", {"numberOfLayers": 1}, [("addRenderer", renderer)]) | {
        "mtime": 1
    }


def _actor(number: int, layer: Layer, frame: ViewFrame, arrays: dict[str, dict[str, str]]) -> dict[str, Any]:
    name = f"layer{number}"
    data = _object("vtkPolyData", f"{name}-data", f"{name}-mapper", _polydata(layer, frame, arrays))
    coloring = {
        "scalarVisibility": layer.colors is not None,
        "scalarMode": _CELL_FIELD,
        "colorByArrayName": "color",
    }
    mapper = _object(
        "vtkMapper",
        f"{name}-mapper",
        name,
        {**coloring, "arrayAccessMode": 1, "colorMode": 2},
        [("setInputData", data)],
    )
    look = _object("vtkProperty", f"{name}-property", name, _property(layer))
    return _object(
        "vtkActor",
        name,
        "renderer",
        {"visibility": layer.shown},
        [("setMapper", mapper), ("setProperty", look)],
    )


def _property(layer: Layer) -> dict[str, Any]:
    color = rgb(layer.color)
    shading = {"ambient": 0.5, "diffuse": 0.55} if layer.lit else {"ambient": 1.0, "diffuse": 0.0}
    return shading | {
        "representation": 2,
        "interpolation": 0,
        "lighting": layer.lit,
        "diffuseColor": color,
        "ambientColor": color,
        "color": color,
        "edgeColor": rgb(_EDGE_COLOR),
        "edgeVisibility": layer.edges,
        "opacity": layer.opacity,
        "pointSize": 9,
        "lineWidth": 1,
    }


def _polydata(layer: Layer, frame: ViewFrame, arrays: dict[str, dict[str, str]]) -> dict[str, Any]:
    width = layer.cells.shape[1]
    kind = {1: "verts", 2: "lines"}.get(width, "polys")
    packed = np.insert(layer.cells, 0, width, axis=1).astype(np.uint32)
    fields = []
    if layer.colors is not None:
        colors = _array(layer.colors, "vtkDataArray", arrays) | {"name": "color"}
        fields = [colors | {"location": "cellData", "registration": "addArray"}]
    return {
        "points": _array(frame.apply(layer.V), "vtkPoints", arrays),
        kind: _array(packed.reshape(-1, 1), "vtkCellArray", arrays),
        "fields": fields,
    }


_JAVASCRIPT = {"float32": "Float32Array", "uint32": "Uint32Array", "uint8": "Uint8Array"}


def _array(values: Any, kind: str, arrays: dict[str, dict[str, str]]) -> dict[str, Any]:
    """Reference to values (n,k), whose content goes to `arrays`."""
    content = np.ascontiguousarray(values).tobytes()
    digest = hashlib.sha256(content).hexdigest()[:32]
    arrays[digest] = {"content": base64.b64encode(content).decode()}
    return {
        "vtkClass": kind,
        "hash": digest,
        "dataType": _JAVASCRIPT[str(values.dtype)],
        "numberOfComponents": values.shape[1],
        "size": values.size,
    }


def _object(
    kind: str,
    name: str,
    parent: str,
    properties: dict[str, Any],
    parts: Sequence[tuple[str, dict[str, Any]]] = (),
) -> dict[str, Any]:
    """An object of vtk.js with its `parts`: (method that takes it, object)."""
    return {
        "parent": parent,
        "id": name,
        "type": kind,
        "properties": properties,
        "dependencies": [part for _, part in parts],
        "calls": [[method, [f"instance:${{{part['id']}}}"]] for method, part in parts],
    }
