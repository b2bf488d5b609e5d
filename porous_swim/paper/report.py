"""The comparison of ours against theirs, over all reproduced figures, as one page and one table."""

from __future__ import annotations

import csv
import difflib
import time
from collections.abc import Sequence
from pathlib import Path

from porous_swim.errors import ResultsError, SceneError
from porous_swim.paper import FIGURES
from porous_swim.paper.figure import AGREES, DIFFERS, HEADER, REPORTED, Reproduction


def chosen(names: Sequence[str]) -> list[str]:
    """The figures named, in the paper's order; all where none is. `SceneError` for an unknown name."""
    for name in names:
        if name not in FIGURES:
            near = difflib.get_close_matches(name, FIGURES, n=1)
            hint = f" (did you mean {near[0]}?)" if near else ""
            raise SceneError(f"reproduce {name}: there is no such figure{hint}; there are: {', '.join(FIGURES)}")
    return [name for name in FIGURES if not names or name in names]


def reproduce(names: Sequence[str], folder: Path, *, quick: bool) -> tuple[int, int]:
    """Make figures again into `folder`, telling of each on stdout; number of rows that agree and that differ."""
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
            print("  " + "  ".join(cell for cell in row.cells() if cell))
        print(f"  {made[name][1]:.0f} s", flush=True)
        _write(folder, made, quick=quick)
    rows = [row for figure, _ in made.values() for row in figure.rows if row.tolerance is not None]
    n_differ = sum(row.verdict == DIFFERS for row in rows)
    return len(rows) - n_differ, n_differ


def _write(folder: Path, made: dict[str, tuple[Reproduction, float]], *, quick: bool) -> None:
    with (folder / "comparison.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(["figure", *HEADER])
        writer.writerows([name, *row.cells()] for name, (figure, _) in made.items() for row in figure.rows)
    (folder / "comparison.md").write_text(_page(made, quick=quick), encoding="utf-8")


def _page(made: dict[str, tuple[Reproduction, float]], *, quick: bool) -> str:
    verdicts = [row.verdict for figure, _ in made.values() for row in figure.rows]
    lines = ["# Figures of Soft Matter 11, 3396 (2015), made again", ""]
    lines += [
        f"{verdicts.count(AGREES)} numbers agree with the independent value, {verdicts.count(DIFFERS)} differ, "
        f"{verdicts.count(REPORTED)} have none. To agree means: without noise within 0.1 % or a unit of the last digit "
        "known, with noise within 4 combined standard errors.", "",
    ]  # fmt: skip
    lines += ["Reduced counts (`--quick`).", ""] if quick else []
    for name, (figure, seconds) in made.items():
        lines += [f"## {name}", "", FIGURES[name][0] + f". Made in {seconds:.0f} s.", "", f"![{name}]({name}.png)", ""]
        lines += ["| " + " | ".join(HEADER) + " |", "|" + "---|" * len(HEADER)]
        lines += ["| " + " | ".join(cell.replace("|", "\\|") for cell in row.cells()) + " |" for row in figure.rows]
        lines += ["", *figure.notes, ""] if figure.notes else [""]
    return "\n".join(lines)
