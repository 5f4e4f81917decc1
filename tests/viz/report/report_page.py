"""The HTML of a report, read by tests."""

from __future__ import annotations

import json
from html.parser import HTMLParser
from typing import Any


class ReportPage(HTMLParser):
    """Tags with attributes, text of script elements, and text of cells with attributes."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str]]] = []
        self.scripts: list[tuple[dict[str, str], str]] = []
        self.cells: list[tuple[dict[str, str], str]] = []
        self.words = ""
        self.inside = False
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, {name: value or "" for name, value in attrs}))
        self.inside = True

    def handle_endtag(self, tag: str) -> None:
        self.inside = False

    def handle_data(self, data: str) -> None:
        tag, attributes = self.tags[-1] if self.inside else ("", {})
        if tag == "script":
            self.scripts.append((attributes, data))
        elif tag != "style":
            self.words += f" {' '.join(data.split())}"
            if "data-key" in attributes:
                self.cells.append((attributes, data))

    def json(self, name: str) -> Any:
        return json.loads(next(text for attributes, text in self.scripts if attributes.get("id") == name))
