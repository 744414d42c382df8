"""Charts as inline SVG; the page's style sheet gives them their colours."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from markupsafe import Markup, escape

from neurframe_cli.report.axis import linear_ticks, log_ticks, tick_label

_WIDTH, _HEIGHT = 640, 260
_LEFT, _RIGHT, _TOP, _BOTTOM = 64, 12, 12, 44
_MOST_POINTS = 500


@dataclass(frozen=True)
class Series:
    """A curve: its name and its points (x, y)."""

    name: str
    points: Sequence[tuple[float, float]]


def curve_chart(series: Sequence[Series], x_title: str, y_title: str) -> Markup:
    """Curves over a logarithmic y; points that have no logarithm are left out, and nothing is drawn without a point."""
    shown = [Series(one.name, _positive(one.points)) for one in series]
    shown = [one for one in shown if one.points]
    if not shown:
        return Markup("")
    xs = [x for one in shown for x, _ in one.points]
    ys = [y for one in shown for _, y in one.points]
    low, high = min(ys), max(ys)
    if low == high:
        low, high = low / 2, high * 2
    along, up = _along(min(xs), max(xs)), _up(math.log10(low), math.log10(high))
    parts = [_grid(linear_ticks(min(xs), max(xs)), log_ticks(low, high), along, lambda y: up(math.log10(y)))]
    for number, one in enumerate(shown):
        path = " ".join(f"{along(x):.1f},{up(math.log10(y)):.1f}" for x, y in _thinned(one.points))
        parts.append(Markup('<polyline class="curve c{}" points="{}"/>').format(number % 4, path))
        x, y = one.points[-1]
        parts.append(
            Markup('<circle class="curve-end c{}" cx="{:.1f}" cy="{:.1f}" r="3"/>').format(
                number % 4, along(x), up(math.log10(y))
            )
        )
    return _figure(parts, x_title, y_title, f"{y_title} over {x_title}") + _legend(shown)


def histogram_chart(
    edges: Sequence[float], counts: Sequence[int], color: Callable[[float], str], x_title: str, y_title: str
) -> Markup:
    """Bars of height log(1 + count): a handful of bad cells among thousands of good ones must be seen."""
    most = max(counts)
    along, up = _along(edges[0], edges[-1]), _up(0.0, math.log10(1 + most))
    ticks = [0.0, *(10.0**k for k in range(math.ceil(math.log10(1 + most))))]
    parts = [_grid(linear_ticks(edges[0], edges[-1]), ticks, along, lambda y: up(math.log10(1 + y)))]
    for left, right, count in zip(edges[:-1], edges[1:], counts, strict=True):
        if count:
            parts.append(
                _bar(
                    along(left),
                    along(right),
                    up(math.log10(1 + count)),
                    color((left + right) / 2),
                    left,
                    right,
                    count,
                )
            )
    return _figure(parts, x_title, y_title, f"{y_title} by {x_title}")


def _bar(x0: float, x1: float, top: float, color: str, left: float, right: float, count: int) -> Markup:
    return Markup(
        '<rect class="bar" x="{:.1f}" y="{:.1f}" width="{:.1f}" height="{:.1f}" fill="{}">'
        "<title>{:g} to {:g}: {}</title></rect>"
    ).format(x0 + 0.5, top, x1 - x0 - 1, _HEIGHT - _BOTTOM - top, color, left, right, count)


def _positive(points: Sequence[tuple[float, float]]) -> list[tuple[float, float]]:
    return [(x, y) for x, y in points if math.isfinite(x) and math.isfinite(y) and y > 0]


def _thinned(points: Sequence[tuple[float, float]]) -> list[tuple[float, float]]:
    """About 500 of them, the last one among them."""
    stride = max(1, len(points) // _MOST_POINTS)
    return [*points[:-1:stride], points[-1]]


def _along(low: float, high: float) -> Callable[[float], float]:
    span = high - low or 1.0
    return lambda x: _LEFT + (x - low) / span * (_WIDTH - _LEFT - _RIGHT)


def _up(low: float, high: float) -> Callable[[float], float]:
    span = high - low or 1.0
    return lambda y: _HEIGHT - _BOTTOM - (y - low) / span * (_HEIGHT - _TOP - _BOTTOM)


def _grid(
    xs: Sequence[float], ys: Sequence[float], along: Callable[[float], float], up: Callable[[float], float]
) -> Markup:
    base = _HEIGHT - _BOTTOM
    parts = [
        Markup(
            '<line class="grid" x1="{}" x2="{}" y1="{:.1f}" y2="{:.1f}"/>'
            '<text x="{}" y="{:.1f}" class="tick y">{}</text>'
        ).format(_LEFT, _WIDTH - _RIGHT, up(y), up(y), _LEFT - 6, up(y) + 4, tick_label(y))
        for y in ys
    ]
    parts += [
        Markup(
            '<line class="grid" x1="{:.1f}" x2="{:.1f}" y1="{}" y2="{}"/>'
            '<text x="{:.1f}" y="{}" class="tick x">{}</text>'
        ).format(along(x), along(x), base, base + 4, along(x), base + 18, tick_label(x))
        for x in xs
    ]
    return Markup("").join(parts)


def _figure(parts: Sequence[Markup], x_title: str, y_title: str, label: str) -> Markup:
    titles = Markup(
        '<text class="axis" x="{}" y="{}" text-anchor="middle">{}</text>'
        '<text class="axis" x="14" y="{}" text-anchor="middle" transform="rotate(-90 14 {})">{}</text>'
    ).format(
        (_LEFT + _WIDTH - _RIGHT) / 2, _HEIGHT - 6, x_title, *[(_TOP + _HEIGHT - _BOTTOM) / 2] * 2, y_title
    )
    return Markup('<svg class="chart" viewBox="0 0 {} {}" role="img" aria-label="{}">{}{}</svg>').format(
        _WIDTH, _HEIGHT, label, Markup("").join(parts), titles
    )


def _legend(series: Sequence[Series]) -> Markup:
    entries = (
        Markup('<li class="c{}">{}</li>').format(n % 4, escape(one.name)) for n, one in enumerate(series)
    )
    return Markup('<ul class="legend">{}</ul>').format(Markup("").join(entries))
