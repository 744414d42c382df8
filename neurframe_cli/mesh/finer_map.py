"""An integer-grid map with more integers: the same map, k times as many cells along each of its edges."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

from neurframe_cli.errors import StageError

INDICES = 4  # of a tet's line; the parameters follow


def write_finer_map(source: Path, target: Path, times: int) -> None:
    """Write the map of a .hexex file with all parameters multiplied by `times`, a whole number.

    Multiples of integers are integers: the map stays an integer-grid map, and every cell falls into times³.  Parameters
    may be decimals or exact fractions `a/b`.  Raises StageError where `source` is not laid out so: a line for each
    vertex and each tet, with their numbers before.
    """
    lines = source.read_text().splitlines()
    try:
        _write(lines, target, times)
    except (ValueError, IndexError) as error:
        raise StageError(f"{source.name} cannot be made finer: {error}") from error


def _write(lines: list[str], target: Path, times: int) -> None:
    first = int(lines[0]) + 2
    tets = int(lines[first - 1])
    with target.open("w") as out:
        out.writelines(f"{line}\n" for line in lines[:first])
        for line in lines[first : first + tets]:
            words = line.split()
            parameters = [_multiplied(word, times) for word in words[INDICES:]]
            out.write(" ".join([*words[:INDICES], *parameters]) + "\n")


def _multiplied(word: str, times: int) -> str:
    return str(Fraction(word) * times) if "/" in word else repr(float(word) * times)
