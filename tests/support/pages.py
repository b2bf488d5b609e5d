"""Reading a report's page as a browser would: strictly nested HTML, its tables and its pictures."""

from __future__ import annotations

from html.parser import HTMLParser
from pathlib import Path

_VOID = {"meta", "link", "img", "br"}


class Page(HTMLParser):
    """What is on a page; wrong nesting is an AssertionError."""

    def __init__(self, path: Path) -> None:
        super().__init__(convert_charrefs=True)
        self.path = path
        self.source = path.read_text(encoding="utf-8")
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.texts: list[str] = []
        self.rows: dict[str, list[list[tuple[str, str | None]]]] = {}
        """By id of the section: rows of cells, each its text and the value of its number."""
        self._open: list[str] = []
        self._section = ""
        self.feed(self.source)
        self.close()
        assert self._open == []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))
        if tag in _VOID:
            return
        self._open.append(tag)
        if tag == "section":
            self._section = str(dict(attrs)["id"])
            self.rows[self._section] = []
        elif tag == "tr":
            self.rows[self._section].append([])
        elif tag in ("td", "th"):
            self.rows[self._section][-1].append(("", None))
        elif tag == "data":
            text, _ = self.rows[self._section][-1][-1]
            self.rows[self._section][-1][-1] = (text, dict(attrs)["value"])

    def handle_endtag(self, tag: str) -> None:
        assert self._open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.texts.append(data)
        if {"td", "th"} & set(self._open) and "small" not in self._open:
            text, value = self.rows[self._section][-1][-1]
            self.rows[self._section][-1][-1] = (text + data, value)

    @property
    def text(self) -> str:
        """All text."""
        return "".join(self.texts)

    def attributes(self, tag: str) -> list[dict[str, str | None]]:
        """Of all elements with that tag."""
        return [found for name, found in self.tags if name == tag]
