"""Paths as users give them."""

from __future__ import annotations

import os
from pathlib import Path

from porous_swim.core.errors import ResultsError


def absolute(path: Path | str) -> Path:
    """Return a path from the root, with `~` for the home; libraries and a change of folder then read it alike.

    ResultsError where it is no text: those that write tables and recordings take only paths in UTF-8.
    """
    try:
        full = Path(os.path.abspath(Path(path).expanduser()))
    except RuntimeError as error:
        raise ResultsError(f"{path}: there is no such home folder") from error
    try:
        str(full).encode()
    except UnicodeEncodeError as error:
        raise ResultsError(
            f"{os.fsencode(full)!r}: the path is not UTF-8, as tables and recordings need it; name another folder"
        ) from error
    return full
