"""The table of encounter columns in docs/statistics.md: `python -m porous_swim.results.encounter_page` writes it."""

from __future__ import annotations

from pathlib import Path

from porous_swim.results.encounter_columns import COLUMNS, Kind

PAGE_FILE = Path(__file__).parents[2] / "docs" / "statistics.md"
BEGIN = "<!-- Written by `python -m porous_swim.results.encounter_page` from the list of columns; do not edit. -->"
END = "<!-- End of the list of columns. -->"

_TYPES = {
    Kind.FLAG: "true or false", Kind.SWIMMER: "whole number", Kind.COLLOID: "whole number", Kind.IMAGE: "whole number",
}  # fmt: skip


def column_table() -> str:
    """Return the part of the page between the markers: a row for each column."""
    rows = [
        f"| `{column.name}` | {column.meaning} | {column.unit} | {_TYPES.get(column.kind, 'number')} | {column.null} |"
        for column in COLUMNS
    ]
    return "\n".join(["| column | meaning | unit | type | null |", "|---|---|---|---|---|", *rows]) + "\n"


def page(text: str) -> str:
    """Return the page `text` with the part between the markers written anew."""
    before, begin, rest = text.partition(BEGIN)
    _, end, after = rest.partition(END)
    if not (begin and end):
        raise ValueError(f"{PAGE_FILE.name} lacks the lines {BEGIN!r} and {END!r}, between which the table goes")
    return f"{before}{BEGIN}\n\n{column_table()}\n{END}{after}"


def write() -> None:
    """Write the table into the page."""
    PAGE_FILE.write_text(page(PAGE_FILE.read_text(encoding="utf-8")), encoding="utf-8")


if __name__ == "__main__":
    write()
