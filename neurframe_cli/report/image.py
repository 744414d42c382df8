"""Pictures as part of the page."""

from __future__ import annotations

import base64
import io
from pathlib import Path

MOST_PIXELS_ACROSS = 1280
_QUALITY = 82  # of 100; lines stay sharp, and a picture of 800 kB becomes one of 100


def data_uri(path: Path) -> str:
    """The picture in `path`, made smaller, as an address that holds all of it; raises OSError where it is none."""
    from PIL import Image

    with Image.open(path) as picture:
        page = picture.convert("RGB")
    page.thumbnail((MOST_PIXELS_ACROSS, MOST_PIXELS_ACROSS))
    content = io.BytesIO()
    page.save(content, format="WEBP", quality=_QUALITY, method=2)
    return "data:image/webp;base64," + base64.b64encode(content.getvalue()).decode()
