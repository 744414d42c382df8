"""Reading a page back without a browser: is it well-formed, and what does it ask the network for?"""

from __future__ import annotations

import json
from html.parser import HTMLParser
from typing import Any

VOID = {"meta", "link", "img", "br", "input", "hr"}
ADDRESSES = ("src", "href", "action", "data", "poster", "srcset")


class Page(HTMLParser):
    """elements: (tag, attributes) in order; scripts: content by id, else by number; text: the rest."""

    def __init__(self, html: str) -> None:
        super().__init__(convert_charrefs=True)
        self.elements: list[tuple[str, dict[str, str | None]]] = []
        self.scripts: dict[str, str] = {}
        self.text = ""
        self._open: list[str] = []
        self.feed(html)
        self.close()
        assert not self._open, f"never closed: {self._open}"

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, dict(attrs)))
        if tag not in VOID:
            self._open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, dict(attrs)))

    def handle_endtag(self, tag: str) -> None:
        assert self._open, f"</{tag}> closes nothing"
        assert self._open.pop() == tag, f"</{tag}> closes another element"

    def handle_data(self, data: str) -> None:
        if self._open and self._open[-1] == "script":
            name = self.elements[-1][1].get("id") or str(len(self.scripts))
            self.scripts[name] = self.scripts.get(name, "") + data
        elif not self._open or self._open[-1] != "style":
            self.text += data

    def all(self, tag: str) -> list[dict[str, str | None]]:
        """Attributes of every such element."""
        return [attributes for name, attributes in self.elements if name == tag]

    def json(self, name: str) -> Any:
        """The JSON of the script element with this id."""
        return json.loads(self.scripts[name])

    def addresses(self) -> list[str]:
        """Everything that a browser would fetch or follow, but for parts of this page and what it holds itself."""
        found = [attributes.get(name) for _, attributes in self.elements for name in ADDRESSES]
        return [address for address in found if address and not address.startswith(("data:", "#"))]

    def handlers(self) -> list[str]:
        """Attributes that are scripts."""
        return [name for _, attributes in self.elements for name in attributes if name.startswith("on")]
