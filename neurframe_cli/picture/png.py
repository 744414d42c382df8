"""A rendered image with its legend as a PNG file."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

TEXT_COLOR = "#30363d"
_FONT_PIXELS, _LINE_PIXELS, _MARGIN_PIXELS = 24, 34, 28


def write_png(path: Path, image: Any, legend: Sequence[tuple[str, str]]) -> None:
    """Writes image (h,w,3) uint8 as PNG, whatever the name ends in; legend: (text, colour) lines, bottom left."""
    from PIL import Image, ImageDraw, ImageFont

    page = Image.fromarray(image)
    pen, font = ImageDraw.Draw(page), ImageFont.load_default(_FONT_PIXELS)
    top = page.height - _MARGIN_PIXELS - _LINE_PIXELS * len(legend)
    for line, (text, color) in enumerate(legend):
        y = top + _LINE_PIXELS * line
        box = (_MARGIN_PIXELS, y, _MARGIN_PIXELS + _FONT_PIXELS, y + _FONT_PIXELS)
        pen.rectangle(box, fill=color, outline=TEXT_COLOR)
        pen.text((box[2] + 12, (box[1] + box[3]) / 2), text, fill=TEXT_COLOR, font=font, anchor="lm")
    page.save(path, format="PNG")
