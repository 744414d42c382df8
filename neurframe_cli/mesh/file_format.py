"""Which format a file has, by what stands in it; the extension decides only where the content is silent."""

from __future__ import annotations

import re
import struct
from pathlib import Path

from neurframe_cli.errors import UnreadableFile, UnsupportedFormat
from neurframe_cli.mesh.open_file import check_file

SURFACE_FORMATS = ("stl", "obj", "ply", "off", "3mf", "glb", "gltf", "step")
CELL_FORMATS = ("medit", "vtk", "vtu", "msh", "ovm")  # may hold tets, triangles, or both

EXTENSIONS = {
    ".stl": "stl",
    ".obj": "obj",
    ".ply": "ply",
    ".off": "off",
    ".3mf": "3mf",
    ".glb": "glb",
    ".gltf": "gltf",
    ".step": "step",
    ".stp": "step",
    ".mesh": "medit",
    ".vtk": "vtk",
    ".vtu": "vtu",
    ".msh": "msh",
    ".ovm": "ovm",
}

HEAD_BYTES = 4096
STL_HEADER = 84  # 80 bytes of text, then the number of triangles
STL_TRIANGLE = 50

# first bytes (after white space) of the formats that have a signature
SIGNATURES: tuple[tuple[re.Pattern[bytes], str], ...] = (
    (re.compile(rb"OVM ASCII", re.IGNORECASE), "ovm"),
    (re.compile(rb"(#[^\n]*\n\s*)*MeshVersionFormatted"), "medit"),
    (re.compile(rb"# vtk DataFile", re.IGNORECASE), "vtk"),
    (re.compile(rb"(<\?xml[^>]*>\s*)?(<!--.*?-->\s*)*<VTKFile", re.DOTALL), "vtu"),
    (re.compile(rb"\$(MeshFormat|Comments|NOD)"), "msh"),
    (re.compile(rb"ply\r?\n"), "ply"),
    (re.compile(rb"(#[^\n]*\n\s*)*(ST)?C?N?4?n?OFF\b"), "off"),
    (re.compile(rb"PK\x03\x04"), "3mf"),
    (re.compile(rb"glTF"), "glb"),
    (re.compile(rb'\{(?=[\s\S]*"(asset|scenes?|meshes|accessors|buffers)")'), "gltf"),
    (re.compile(rb"ISO-10303-21"), "step"),
)

REFUSED: tuple[tuple[re.Pattern[bytes], str, str], ...] = (
    (re.compile(rb"OVMB\n"), "binary OpenVolumeMesh (OVMB)", "convert it to the text format .ovm"),
    # the number 1 and the version, 1 to 4, as 32-bit integers of either byte order
    (
        re.compile(rb"\x01\0\0\0[\x01-\x04]\0\0\0|\0\0\0\x01\0\0\0[\x01-\x04]"),
        "binary MEDIT (.meshb)",
        "write it as text .mesh",
    ),
)

OBJ_LINE = re.compile(rb"(v|vt|vn|f|o|g|s|l|usemtl|mtllib)\s")


def file_format(path: Path) -> str:
    """One of SURFACE_FORMATS or CELL_FORMATS.  Raises UnreadableFile or UnsupportedFormat."""
    check_file(path)
    try:
        with path.open("rb") as file:
            head = file.read(HEAD_BYTES)
    except OSError as error:
        raise UnreadableFile(f"{path}: {error}") from error
    found = _by_content(path, head)
    if found is not None:
        return found
    by_name = EXTENSIONS.get(path.suffix.lower())
    if by_name is None:
        raise UnsupportedFormat(
            f"{path}: not a mesh format that neurframe reads",
            hint="formats: " + ", ".join(sorted({name.lstrip(".") for name in EXTENSIONS})),
        )
    if by_name not in ("obj", "stl"):  # every other format starts with its signature
        raise UnreadableFile(f"{path}: the name says {by_name}, the content does not")
    return by_name


def _by_content(path: Path, head: bytes) -> str | None:
    if _is_binary_stl(path, head):
        return "stl"
    for pattern, kind, hint in REFUSED:
        if pattern.match(head):
            raise UnsupportedFormat(f"{path}: {kind} is not read", hint=hint)
    start = head.removeprefix(b"\xef\xbb\xbf").lstrip()
    for pattern, name in SIGNATURES:
        if pattern.match(start):
            return name
    if start[:5].lower() == b"solid":
        return "stl"
    if b"\0" not in head and any(OBJ_LINE.match(line.lstrip()) for line in start.split(b"\n")):
        return "obj"
    return None


def _is_binary_stl(path: Path, head: bytes) -> bool:
    """Binary STL has no signature and its header may even begin with `solid`; its size gives it away."""
    if len(head) < STL_HEADER:
        return False
    (triangles,) = struct.unpack_from("<I", head, 80)
    return bool(path.stat().st_size == STL_HEADER + STL_TRIANGLE * triangles)
