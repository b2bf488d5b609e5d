"""The comparison of ours against theirs, over all reproduced figures, as one page and one table."""

from __future__ import annotations

import csv
import difflib
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from porous_swim.core.errors import ResultsError, SceneError
from porous_swim.paper import FIGURES
from porous_swim.paper.figure import AGREES, DIFFERS, HEADER, REPORTED, Reproduction, Row


def chosen(names: Sequence[str]) -> list[str]:
    """The figures named, in the paper's order; all where none is. `SceneError` for an unknown name."""
    for name in names:
        if name not in FIGURES:
            near = difflib.get_close_matches(name, FIGURES, n=1)
            hint = f" (did you mean {near[0]}?)" if near else ""
            raise SceneError(f"reproduce {name}: there is no such figure{hint}; there are: {', '.join(FIGURES)}")
    return [name for name in FIGURES if not names or name in names]


@dataclass(frozen=True)
class Counts:
    """How many numbers agree and differ."""

    n_agree: int
    n_differ: int

    @classmethod
    def of(cls, verdicts: Sequence[str]) -> Counts:
        """Of verdicts; others than those two do not count."""
        return cls(verdicts.count(AGREES), verdicts.count(DIFFERS))

    def __str__(self) -> str:
        """In words."""
        return f"{self.n_agree} agree and {self.n_differ} differ"


def reproduce(names: Sequence[str], folder: Path, *, quick: bool) -> tuple[Counts, Counts]:
    """Make figures again into `folder`, telling of each on stdout; counts against paper and independent program."""
    wanted = chosen(names)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ResultsError(f"{folder}: cannot be created ({error.strerror})") from None
    made: dict[str, tuple[Reproduction, float]] = {}
    for name in wanted:
        title, make = FIGURES[name]
        print(f"{name}: {title}", flush=True)
        begin = time.perf_counter()
        figure = make(quick)
        figure.write(folder, name)
        made[name] = figure, time.perf_counter() - begin
        for row in figure.rows:
            print("  " + _told(row))
        print(f"  {made[name][1]:.0f} s", flush=True)
        _write(folder, made, quick=quick)
    rows = [row for figure, _ in made.values() for row in figure.rows]
    return Counts.of([row.paper_verdict for row in rows]), Counts.of([row.verdict for row in rows])


def _told(row: Row) -> str:
    """A row in a line, each cell under its name."""
    names = ["", "paper ", "ours ", "independent ", "paper: ", "independent: "]
    return "  ".join(name + cell for name, cell in zip(names, row.cells(), strict=True) if cell)


def _write(folder: Path, made: dict[str, tuple[Reproduction, float]], *, quick: bool) -> None:
    with (folder / "comparison.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(["figure", *HEADER])
        writer.writerows([name, *row.cells()] for name, (figure, _) in made.items() for row in figure.rows)
    (folder / "comparison.md").write_text(_page(made, quick=quick), encoding="utf-8")


def summary_lines(rows: Sequence[Row]) -> list[str]:
    """What both comparisons came to."""
    independent = [row.verdict for row in rows]
    n_paper = sum(bool(row.paper_verdict) for row in rows)
    return [
        f"Of {len(rows)} numbers the paper prints {n_paper}: {Counts.of([row.paper_verdict for row in rows])}. "
        f"An independent program of the same model has {len(rows) - independent.count(REPORTED)}: "
        f"{Counts.of(independent)}.",
        "",
        "To agree with the paper means: within what it rounds away or 0.1 %, and 4 standard errors of ours; of its own "
        "errors the paper says nothing. To agree with the independent program means: without noise within 0.1 % or a "
        "unit of the last digit known, with noise within 4 combined standard errors. Where ours agrees with the second "
        "and differs from the first, the paper's number does not follow from its own model, or it is a formula to "
        "leading order: docs/paper.md says which.",
    ]  # fmt: skip


def _page(made: dict[str, tuple[Reproduction, float]], *, quick: bool) -> str:
    rows = [row for figure, _ in made.values() for row in figure.rows]
    lines = ["# Figures of Soft Matter 11, 3396 (2015), made again", "", *summary_lines(rows), ""]
    lines += ["Reduced counts (`--quick`).", ""] if quick else []
    for name, (figure, seconds) in made.items():
        lines += [f"## {name}", "", FIGURES[name][0] + f". Made in {seconds:.0f} s.", "", f"![{name}]({name}.png)", ""]
        lines += ["| " + " | ".join(HEADER) + " |", "|" + "---|" * len(HEADER)]
        lines += ["| " + " | ".join(cell.replace("|", "\\|") for cell in row.cells()) + " |" for row in figure.rows]
        lines += ["", *figure.notes, ""] if figure.notes else [""]
    return "\n".join(lines)
