"""Limited-memory BFGS for energies that are infinite outside their domain (Nocedal & Wright, chapter 7.2)."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from neurframe_cli.mesh.arrays import Floats

# energy and gradient at x, both of x's shape; the energy may be inf, the gradient is then not used
Energy = Callable[[Floats], tuple[float, Floats]]
SUFFICIENT_DECREASE, SLOPE_LEFT = 1e-4, 0.9  # the two Wolfe conditions
MAX_TRIALS = 25


@dataclass(frozen=True)
class LbfgsOptions:
    """iterations at most; memory: pairs kept; tolerance: relative decrease of the energy at which it stops."""

    iterations: int = 30
    memory: int = 8
    tolerance: float = 1e-7


def minimise(energy: Energy, x: Floats, scale: Floats, options: LbfgsOptions) -> tuple[Floats, float]:
    """Minimiser of `energy` near x (n,3), reached by feasible, decreasing steps, and the decrease of the energy.

    scale (n,1) is the inverse of a diagonal guess of the Hessian.  If every gradient lies in a linear subspace (of
    tangents) and scale does not leave it, all steps do; and the result follows rotations of x.
    """
    value, gradient = energy(x)
    first = value
    pairs: deque[tuple[Floats, Floats, float]] = deque(maxlen=options.memory)
    for _ in range(options.iterations):
        direction = -_inverse_hessian_product(gradient, pairs, scale)
        # the first gradient of a tangled mesh is huge: no vertex goes farther than its own scale
        far = 0.0 if pairs else float(np.sqrt((direction**2).sum(axis=1, keepdims=True) / scale).max())
        found = _line_search(energy, x, value, gradient, direction / max(1.0, far))
        if found is None:
            break
        new_x, new_value, new_gradient = found
        step, change = new_x - x, new_gradient - gradient
        curvature = _product(step, change)
        if curvature > 1e-12 * _product(change, scale * change):
            pairs.append((step, change, curvature))
        decrease = value - new_value
        x, value, gradient = new_x, new_value, new_gradient
        if decrease <= options.tolerance * abs(value):
            break
    return x, first - value


def _inverse_hessian_product(
    gradient: Floats, pairs: deque[tuple[Floats, Floats, float]], scale: Floats
) -> Floats:
    result = gradient.copy()
    coefficients = []
    for step, change, curvature in reversed(pairs):
        coefficients.append(_product(step, result) / curvature)
        result -= coefficients[-1] * change
    result *= scale
    if pairs:
        _, change, curvature = pairs[-1]
        result *= curvature / _product(change, scale * change)
    for (step, change, curvature), coefficient in zip(pairs, reversed(coefficients), strict=True):
        result += (coefficient - _product(change, result) / curvature) * step
    return result


def _line_search(
    energy: Energy, x: Floats, value: float, gradient: Floats, direction: Floats
) -> tuple[Floats, float, Floats] | None:
    """A step with the weak Wolfe conditions by bisection (Lewis & Overton 2013), or the last that decreases, or None.

    Trials beyond the domain, where the energy is inf, count as too long.
    """
    slope = _product(gradient, direction)
    if slope >= 0.0:
        return None
    t, short, long = 1.0, 0.0, np.inf
    found = None
    for _ in range(MAX_TRIALS):
        new = x + t * direction
        new_value, new_gradient = energy(new)
        if not new_value <= value + SUFFICIENT_DECREASE * t * slope:
            long = t
        else:
            found = new, new_value, new_gradient
            if _product(new_gradient, direction) >= SLOPE_LEFT * slope:
                break
            short = t
        t = 2 * short if long == np.inf else (short + long) / 2
    return found


def _product(a: Floats, b: Floats) -> float:
    """Inner product of a and b (n,3): not that of BLAS, whose last bits depend on the number of threads, and with them
    which of two minima is found."""
    return float(np.einsum("nd,nd->", a, b))
