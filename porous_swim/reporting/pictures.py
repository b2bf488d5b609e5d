"""Pictures on disk, and as they go into the page."""

from __future__ import annotations

import io
from dataclasses import dataclass
from pathlib import Path

from matplotlib import rc_context
from matplotlib.figure import Figure

KINDS = {"svg": {"Date": None, "Creator": None}, "png": {"Software": None}}  # and what is not to stand in them
DOTS_PER_INCH = 150
PIXELS_PER_INCH = 96  # of a page
LARGEST_SVG = 400_000  # bytes; beyond, a page shows the PNG


@dataclass(frozen=True)
class Picture:
    """A picture as it goes into the page."""

    content: bytes
    mime: str
    width: int  # pixels of the page
    height: int


def write_picture(figure: Figure, folder: Path, name: str) -> Picture:
    """Write `name.svg` and `name.png` into a folder; equal figures give equal files."""
    files = {}
    with rc_context({"svg.hashsalt": name, "svg.fonttype": "path"}):
        for kind, metadata in KINDS.items():
            buffer = io.BytesIO()
            figure.savefig(buffer, format=kind, dpi=DOTS_PER_INCH, metadata=metadata)
            files[kind] = buffer.getvalue()
            (folder / f"{name}.{kind}").write_bytes(files[kind])
    width, height = (round(PIXELS_PER_INCH * float(inches)) for inches in figure.get_size_inches())
    if len(files["svg"]) <= LARGEST_SVG:
        return Picture(files["svg"], "image/svg+xml", width, height)
    return Picture(files["png"], "image/png", width, height)
