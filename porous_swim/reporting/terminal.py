"""A report in a few lines, for the terminal."""

from __future__ import annotations

from rich.console import Console
from rich.table import Table
from rich.text import Text

from porous_swim.core.console import printable
from porous_swim.core.scales import pretty
from porous_swim.reporting.numbers import NONE, physical, statistics, value_and_error
from porous_swim.reporting.run import Run
from porous_swim.reporting.statistics import name_of
from porous_swim.reporting.write import Report

MAIN = (
    ("residence", "mean"),
    ("escape_pitch_time", "mean"),
    ("winding", "completed"),
    ("hops", "rate"),
    ("hops", "time"),
    ("hops", "length"),
    ("returns", "rate"),
    ("fractions", "bound"),
    ("fractions", "contact"),
    ("msd", "final"),
    ("diffusivity", "effective"),
)
MARK = "(!)"  # after a value that a line below says is not to be trusted
_WIDE = 200  # characters where no terminal sets a width: lines are not broken


def print_report(report: Report) -> None:
    """The main statistics, a column for each run, and the warnings."""
    console = Console(highlight=False)
    if not console.is_terminal:
        console = Console(highlight=False, width=_WIDE)
    table = Table(box=None, padding=(0, 2, 0, 0), header_style="bold")
    for name in ("", "unit", *(run.label for run in report.runs)):
        table.add_column(Text(printable(name)))
    for path in MAIN:
        cells = [_cell(run, path) for run in report.runs]
        if any(cell != NONE for cell in cells):
            unit = _unit(report.runs[0], path)
            table.add_row(Text(name_of(path)), Text(printable(unit)), *(Text(printable(cell)) for cell in cells))
    if table.row_count:
        console.print(table)
    for warning in (*report.warnings, *_statistic_warnings(report)):
        console.print(Text.assemble(("warning  ", "yellow"), printable(warning)), soft_wrap=not console.is_terminal)


def _statistic_warnings(report: Report) -> list[str]:
    """Of the statistics shown, what the report's warnings do not tell."""
    told = " ".join(report.warnings)
    return [
        run.says(f"{name_of(path)}: {found}")
        for path in MAIN
        for run in report.runs
        if (found := statistics(run.results.summary).get(path, {}).get("warning")) and found.split(". ")[0] not in told
    ]


def _unit(run: Run, path: tuple[str, ...]) -> str:
    entry = statistics(run.results.summary).get(path)
    return pretty(entry["unit"]) if entry else ""


def _cell(run: Run, path: tuple[str, ...]) -> str:
    entry = statistics(run.results.summary).get(path)
    if entry is None or entry["value"] is None:
        return NONE
    text = value_and_error(entry["value"], entry["standard_error"])
    second = physical(entry["value"], entry["standard_error"], entry["unit"], run.scales)
    text = f"{text} [{second}]" if second else text
    return f"{text} {MARK}" if entry.get("warning") else text
