"""Where the ticks of a chart's axis stand."""

from __future__ import annotations

import math

_STEPS = (1, 2, 5, 10)


def linear_ticks(low: float, high: float, most: int = 6) -> list[float]:
    """At most `most` + 1 round numbers in [low, high]; one number where the range is empty."""
    if not high > low:
        return [low]
    magnitude = 10.0 ** math.floor(math.log10((high - low) / most))
    step = next(s * magnitude for s in _STEPS if (high - low) / (s * magnitude) <= most)
    first = math.ceil(low / step - 1e-9)
    last = math.floor(high / step + 1e-9)
    return [round(index * step, 12) for index in range(first, last + 1)]


def log_ticks(low: float, high: float, most: int = 6) -> list[float]:
    """Powers of ten in [low, high], thinned out to about `most`; the ends where there is none."""
    first, last = math.ceil(math.log10(low) - 1e-9), math.floor(math.log10(high) + 1e-9)
    if last < first:
        return [low, high]
    stride = max(1, math.ceil((last - first + 1) / most))
    return [10.0**exponent for exponent in range(first, last + 1, stride)]


def tick_label(value: float) -> str:
    """The number as short as it can be read."""
    if value and (abs(value) >= 1e5 or abs(value) < 1e-3):
        mantissa, exponent = f"{value:.0e}".split("e")
        return f"{mantissa}e{int(exponent)}"
    return f"{value:g}"
