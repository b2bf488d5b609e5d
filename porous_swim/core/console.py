"""Lines for people, some of whom stop reading: `porous-swim run ... 2>&1 | head -1`."""

from __future__ import annotations

import os
import re
from contextlib import suppress
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


def tell(line: str, stream: TextIO | None) -> None:
    """Write a line of progress at once. Where it cannot be written (a reader gone, a full disk) the run goes on.

    None is the `sys.stderr` of a process that was started with a closed one.
    """
    if stream is None:
        return
    try:
        print(printable(line), file=stream, flush=True)
    except (OSError, ValueError):  # ValueError: the stream was closed
        silence(stream)


def silence(stream: TextIO) -> None:
    """Send what `stream` still holds, and what comes, to nobody: Python would complain of it once more at its end."""
    with suppress(OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


class Unfailing:
    """A stream for a library that draws on it: what cannot be written is dropped."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self.encoding = getattr(stream, "encoding", "utf-8")

    def write(self, text: str) -> int:
        """Write, or drop this and what comes."""
        try:
            return self._stream.write(text)
        except (OSError, ValueError):
            silence(self._stream)
            return len(text)

    def flush(self) -> None:
        """Flush, or drop what waits."""
        try:
            self._stream.flush()
        except (OSError, ValueError):
            silence(self._stream)

    def isatty(self) -> bool:
        """Whether it is a terminal."""
        return self._stream.isatty()

    def fileno(self) -> int:
        """Of the stream itself."""
        return self._stream.fileno()


def fill_closed_streams() -> None:
    """Open the null device where stdin, stdout or stderr is closed.

    The next file that is opened would get their number, and a library that complains on stderr would write into it.
    """
    for number in (0, 1, 2):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # takes the lowest free number, which is this one
