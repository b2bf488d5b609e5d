"""Lines for people, some of whom stop reading: `porous-swim run ... 2>&1 | head -1`."""

from __future__ import annotations

import os
from typing import TextIO


def tell(line: str, stream: TextIO) -> None:
    """Write a line of progress at once. Where its reader has gone the work goes on, unheard."""
    try:
        print(line, file=stream, flush=True)
    except BrokenPipeError:
        silence(stream)


def silence(stream: TextIO) -> None:
    """Send what `stream` still holds, and what comes, to nobody: Python would complain of it once more at its end."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
