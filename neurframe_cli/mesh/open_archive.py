"""ZIP archives, of which 3MF and .npz files are two: their sizes are looked at before anything is unpacked."""

from __future__ import annotations

import zipfile
from pathlib import Path

from neurframe_cli.errors import UnreadableFile
from neurframe_cli.mesh.open_file import MAX_FILE_BYTES

# deflate reaches 1000:1 only on zeros, XML with coordinates 3:1 to 20:1
MAX_COMPRESSION = 200


def check_archive(path: Path, archive: zipfile.ZipFile) -> list[zipfile.ZipInfo]:
    """The entries; raises UnreadableFile where they unpack to more than any mesh does."""
    entries = archive.infolist()
    unpacked, packed = sum(e.file_size for e in entries), sum(e.compress_size for e in entries)
    if unpacked > MAX_FILE_BYTES or unpacked > MAX_COMPRESSION * max(packed, 1 << 16):
        raise UnreadableFile(
            f"{path}: unpacks from {packed} to {unpacked} bytes, at most {MAX_COMPRESSION} times "
            f"and {MAX_FILE_BYTES >> 20} MiB are allowed"
        )
    return entries
