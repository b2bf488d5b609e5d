"""Tables of numbers in CSV files that a scene names."""

from __future__ import annotations

import csv
import re
from collections.abc import Sequence
from math import isfinite
from pathlib import Path

import numpy as np

from porous_swim.core.parts import LONGEST, KeyedError

_SEPARATORS = {";": "semicolons", "\t": "tabs", " ": "blanks"}
_UNIT = re.compile(r"\s*(\[.*\]|\(.*\)|/.*|_(um|µm|px|nm|mm|pixel|pixels))\s*$", re.IGNORECASE)  # behind a name


def read_columns(
    path: Path, *, key: str, required: Sequence[str], optional: Sequence[str] = ()
) -> dict[str, np.ndarray]:
    """Read a CSV with a header; return one float64 array (n_rows,) per column, optional ones 0 where absent.

    `key` is the scene's key that named the file; every error is a `KeyedError` for it.
    """
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            rows = [(reader.line_num, row) for reader in [csv.reader(file)] for row in reader if any(row)]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        reason = "it is not UTF-8 text" if isinstance(error, UnicodeDecodeError) else getattr(error, "strerror", error)
        raise KeyedError(key, f"the file {str(path)!r} cannot be read: {reason}") from None
    header = [name.strip() for name in rows[0][1]] if rows else []
    wanted = ", ".join(required) + (f" (and {', '.join(optional)})" if optional else "")
    if set(header) - {*required, *optional} or set(required) - set(header) or len(set(header)) != len(header):
        found = ", ".join(header) or "nothing"
        hint = _hint(header, {*required, *optional}, key)
        raise KeyedError(key, f"{path.name}: expected the columns {wanted} in the first line, found {found}{hint}")
    values = np.empty((len(rows) - 1, len(header)))
    for i, (line, row) in enumerate(rows[1:]):
        if len(row) != len(header):
            raise KeyedError(key, f"{path.name}, line {line}: expected {len(header)} numbers, found {len(row)}")
        values[i] = [_number(text, name, path=path, line=line, key=key) for name, text in zip(header, row, strict=True)]
    columns = {name: values[:, i] for i, name in enumerate(header)}
    return {name: columns.get(name, np.zeros(len(values))) for name in (*required, *optional)}


def _hint(header: Sequence[str], names: set[str], key: str) -> str:
    """What to change in a first line that is nearly right: its separators, names with units or capitals."""
    hints, columns = [], list(header)
    for separator, word in _SEPARATORS.items() if len(header) == 1 else ():
        parts = [part.strip() for part in header[0].split(separator)]
        if len(parts) > 1 and {_bare(part) for part in parts} & names:
            hints.append(f"separate columns by commas, not by {word}, and write decimals with a point")
            columns = parts
            break
    if any(name not in names and _bare(name) in names for name in columns):
        unit = " (obstacles.unit says what the numbers are in)" if key.startswith("obstacles") else ""
        hints.append(f"write the names in small letters and without units{unit}")
    return "".join(f"; {hint}" for hint in hints)


def _bare(name: str) -> str:
    """A name without its unit."""
    return _UNIT.sub("", name).lower()


def _number(text: str, name: str, *, path: Path, line: int, key: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = float("nan")
    if not isfinite(value):
        raise KeyedError(key, f"{path.name}, line {line}: {name} must be a finite number, found {text.strip()[:40]!r}")
    if abs(value) > LONGEST:
        raise KeyedError(key, f"{path.name}, line {line}: {name} must be within {LONGEST:g} of 0, found {value:g}")
    return value
