"""Lines for people, some of whom stop reading: `porous-swim run ... 2>&1 | head -1`."""

from __future__ import annotations

import os
import re
from typing import TextIO

# Control characters but line breaks and tabs; those that turn the direction of writing; halves of surrogate pairs,
# which no encoding takes; and what XML forbids.
_UNPRINTABLE = re.compile(
    "[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069\ud800-\udfff\ufffe\uffff]"
)


def printable(text: str) -> str:
    """Return `text` with every character that commands a terminal, or that a page cannot hold, spelled as `\\x1b`.

    Line breaks and tabs stay. Whatever comes from a file, a folder's name or metadata passes through here before it is
    shown; what has passed once is not changed again.
    """
    return _UNPRINTABLE.sub(lambda found: found[0].encode("unicode_escape").decode("ascii"), text)


def tell(line: str, stream: TextIO) -> None:
    """Write a line of progress at once. Where its reader has gone the work goes on, unheard."""
    try:
        print(printable(line), file=stream, flush=True)
    except BrokenPipeError:
        silence(stream)


def silence(stream: TextIO) -> None:
    """Send what `stream` still holds, and what comes, to nobody: Python would complain of it once more at its end."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
