"""Frame fields as text: the `FRA 1` format of CubeCover.

`FRA 1`, then a line `n vectors type`, then for each of n tets its vectors, one `x y z` line each.  The type
is written as 0 and not looked at; programs in use write 0 and 4 for the same content.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from neurframe_cli.errors import InvalidMesh, TooNewFile, UnreadableFile
from neurframe_cli.mesh.arrays import Floats
from neurframe_cli.mesh.open_file import check_file, read_bytes

VERSION = 1
# below this cosine of the smallest angle, three vectors lie so nearly in a plane that they mean no frame
_FLATTEST = 1e-3


def write_fra(path: Path, frames: Floats) -> None:
    """Writes frames (n,3,3), columns are axes, one axis a line, with 17 digits so that they read back exactly."""
    rows = np.swapaxes(frames, 1, 2).reshape(-1, 3)
    with path.open("w", encoding="ascii") as out:
        out.write(f"FRA {VERSION}\n{len(frames)} 3 0\n")
        out.write(("%.17g %.17g %.17g\n" * len(rows)) % tuple(rows.ravel().tolist()))


def read_fra(path: Path) -> Floats:
    """The vectors of the file as they are, (n, vectors, 3); raises UnreadableFile, TooNewFile."""
    tokens = read_bytes(path).split()
    count, vectors = _header(path, tokens)
    if len(tokens) != 5 + 3 * count * vectors:
        raise UnreadableFile(
            f"{path}: {len(tokens) - 5} numbers after the header, {count} x {vectors} vectors have "
            f"{3 * count * vectors}",
            hint="the file may be cut off",
        )
    try:
        numbers = np.array(tokens[5:], dtype=np.bytes_).astype(np.float64)
    except ValueError as error:
        raise UnreadableFile(f"{path}: not a number: {error}") from error
    bad = np.flatnonzero(~np.isfinite(numbers))
    if len(bad):
        raise UnreadableFile(f"{path}: the frame of tet {bad[0] // (3 * vectors)} is not finite")
    return numbers.reshape(count, vectors, 3)


def frame_count(path: Path) -> int:
    """Number of tets that the file has frames for, from its header; raises UnreadableFile, TooNewFile."""
    check_file(path)
    with path.open("rb") as file:
        return _header(path, file.read(1 << 10).split()[:5])[0]


def read_frames(path: Path) -> Floats:
    """Frames (n,3,3), columns are axes, determinant +1: the rotations nearest to the file's vectors.

    The vectors may be of any length and left-handed.  Raises UnreadableFile, TooNewFile, and InvalidMesh where
    there are not three vectors a tet or they lie in a plane.
    """
    vectors = read_fra(path)
    if vectors.shape[1] != 3:
        raise InvalidMesh(f"{path}: {vectors.shape[1]} vectors per tet, a frame has 3")
    length = np.linalg.norm(vectors, axis=2, keepdims=True)
    axes = np.swapaxes(np.divide(vectors, length, out=np.zeros_like(vectors), where=length > 0), 1, 2)
    determinant = np.linalg.det(axes)
    flat = np.flatnonzero(np.abs(determinant) < _FLATTEST)
    if len(flat):
        raise InvalidMesh(f"{path}: the three vectors of tet {flat[0]} lie in a plane")
    left, _, right = np.linalg.svd(axes * np.sign(determinant)[:, None, None])
    return np.asarray(left @ right)


def _header(path: Path, tokens: list[bytes]) -> tuple[int, int]:
    """Numbers of tets and of vectors per tet."""
    if tokens[:1] != [b"FRA"]:
        raise UnreadableFile(f"{path}: not a frame field, its first word is not FRA")
    try:
        version, count, vectors, _ = (int(token) for token in tokens[1:5])
    except ValueError as error:
        raise UnreadableFile(f"{path}: `FRA 1` and `n vectors type` expected at the top ({error})") from error
    if version > VERSION:
        raise TooNewFile(
            f"{path}: FRA version {version}, this neurframe reads {VERSION}", hint="update neurframe"
        )
    if version < 1 or count < 0 or vectors < 1:
        raise UnreadableFile(
            f"{path}: the header says version {version}, {count} tets, {vectors} vectors per tet"
        )
    return count, vectors
