"""What went wrong in a workspace, and where: gathered from what the stages and the executables said."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

from neurframe_cli.pipeline.manifest import Manifest

# what the executables count in their statistics -> what it is called in a report
_QUAD_PLACES = {
    "folded": "folded triangles of the map",
    "overwound": "vertices that the map winds round too often",
}


def troubles(manifest: Manifest) -> list[dict[str, Any]]:
    """Stages that did not end well: `stage`, `status`, `error`, and `defects` with `what`, `count`, `places` (k,3).

    Defects of a stage whose mesh is valid are none: they are not listed.
    """
    return [
        {
            "stage": name,
            "status": record.status,
            "error": record.error,
            "defects": list(defects_of(record.report)),
        }
        for name, record in manifest.stages.items()
        if record.status != "done"
    ]


def defects_of(report: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    """What the two programs of a mesh stage found wrong with its map and its cells, and where cells of a map that were
    replaced are away from the surface: `what`, `count`, `places`."""
    parametrization = _table(report, "parametrization")
    for group in ("defects", "map"):
        for what, entry in _table(parametrization, group).items():
            if isinstance(entry, dict) and entry.get("count"):
                name = f"{what.replace('_', ' ')} {'of the field' if group == 'defects' else 'in the map'}"
                yield _defect(name, entry["count"], entry.get("places"))
    for key, name in _QUAD_PLACES.items():
        if places := parametrization.get(f"{key}_at"):
            yield _defect(name, len(places), places)
    if (far := _table(report, "far_places")).get("count"):
        name = "places of the surface that the hexes of the map are too far from"
        yield _defect(name, far["count"], far.get("places"))
    lost = _table(_table(report, "extraction"), "lost_cells")
    if lost.get("total"):
        places = [entry.get("at") for entry in lost.get("places") or [] if isinstance(entry, dict)]
        causes = ", ".join(f"{count} x {cause}" for cause, count in _table(lost, "causes").items())
        yield _defect(f"cells lost in the extraction ({causes})", lost["total"], places)


def _table(value: Mapping[str, Any], key: str) -> Mapping[str, Any]:
    found = value.get(key)
    return found if isinstance(found, dict) else {}


def _defect(what: str, count: Any, places: Any) -> dict[str, Any]:
    return {"what": what, "count": count, "places": [place for place in places or [] if _is_place(place)]}


def _is_place(value: Any) -> bool:
    return (
        isinstance(value, list)
        and len(value) == 3
        and all(isinstance(x, int | float) and math.isfinite(x) for x in value)
    )
