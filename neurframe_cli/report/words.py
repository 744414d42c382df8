"""Numbers, places and outcomes as a person reads them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any
from urllib.parse import quote

_GOOD = ("valid", "done")
_BAD = ("invalid", "failed", "unusable", "crashed", "out of memory", "lost")


def number(value: Any) -> str:
    """Four digits of a float, an integer in groups of three, yes and no, lists with commas, nothing as a dash."""
    if value is None:
        return "–"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, int):
        return f"{value:,}".replace(",", "\u202f")
    if isinstance(value, float):
        return f"{value:.4g}"
    if isinstance(value, list | tuple):
        return ", ".join(number(entry) for entry in value) or "–"
    return str(value)


def place(at: Sequence[float]) -> str:
    """A position, with enough digits to find it."""
    return ", ".join(f"{x:.6g}" for x in at)


def duration(seconds: float) -> str:
    """Seconds as seconds, minutes or hours."""
    if seconds < 100:
        return f"{seconds:.1f} s"
    minutes = round(seconds) // 60
    return (
        f"{minutes} min {round(seconds) % 60} s" if minutes < 60 else f"{minutes // 60} h {minutes % 60} min"
    )


def flat(value: Mapping[str, Any], prefix: str = "") -> dict[str, Any]:
    """Nested tables as one, with their names joined: {"a": {"b": 1}} -> {"a b": 1}."""
    rows: dict[str, Any] = {}
    for key, entry in value.items():
        name = f"{prefix} {key}".strip().replace("_", " ")
        if isinstance(entry, Mapping):
            rows |= flat(entry, name)
        else:
            rows[name] = entry
    return rows


def all_numbers(values: Iterable[Any]) -> bool:
    """Whether what is there of the values is numbers."""
    there = [value for value in values if value is not None]
    return bool(there) and all(
        isinstance(value, int | float) and not isinstance(value, bool) for value in there
    )


def count(values: Iterable[Any]) -> dict[str, int]:
    """How often each value occurs, the most frequent first."""
    seen: dict[str, int] = {}
    for value in values:
        seen[number(value)] = seen.get(number(value), 0) + 1
    return dict(sorted(seen.items(), key=lambda entry: -entry[1]))


def tone(outcome: Any) -> str:
    """The colour of an outcome: good, bad or warn."""
    return "good" if outcome in _GOOD else "bad" if outcome in _BAD else "warn"


def local_link(path: Any) -> str:
    """A relative path as an address beside the page: never one with a scheme of its own."""
    return "./" + quote(str(path))
