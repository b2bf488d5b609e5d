"""What a section of a report consists of."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from matplotlib.figure import Figure


@dataclass(frozen=True)
class Number:
    """A cell with a number: its text for people, and the number itself for machines; notes and warnings go below it."""

    text: str
    value: float | int
    """NaN where there is none."""
    note: str = ""
    warning: str = ""
    """Why it is not to be trusted."""


Cell = str | Number


@dataclass(frozen=True)
class Table:
    """A table; the first cell of each row names it."""

    header: Sequence[str]
    rows: Sequence[Sequence[Cell]]
    caption: str = ""


@dataclass(frozen=True)
class Section:
    """A heading, sentences, a picture with its caption, tables, and sentences on what is missing."""

    title: str
    name: str
    """Of the section in links and of its picture on disk."""
    text: Sequence[str] = ()
    draw: Callable[[], Figure] | None = None
    caption: str = ""
    tables: Sequence[Table] = ()
    missing: Sequence[str] = ()
    warnings: Sequence[str] = ()
    """For the top of the page."""
    listings: Sequence[tuple[str, str]] = ()
    """Headings and texts to show as they are, folded away."""
