"""A report: from runs to a page on disk and its pictures."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from porous_swim.analysis.places import own_name
from porous_swim.core.errors import ResultsError
from porous_swim.core.paths import absolute
from porous_swim.reporting import (
    density,
    directors,
    displacements,
    fractions,
    hops,
    medium,
    network,
    provenance,
    residence,
    statistics,
    winding,
)
from porous_swim.reporting.numbers import both, counted
from porous_swim.reporting.page import html
from porous_swim.reporting.pictures import KINDS, write_picture
from porous_swim.reporting.run import Run, runs_of, scales_of
from porous_swim.reporting.run_warnings import run_warnings
from porous_swim.reporting.section import Section
from porous_swim.results.manifest import FIGURES, list_report
from porous_swim.results.results import Results
from porous_swim.results.tables import PART

PAGE = "report.html"
SECTIONS: tuple[Callable[[Sequence[Run]], Section], ...] = (
    medium.section,
    fractions.section,
    residence.section,
    winding.section,
    network.section,
    hops.section,
    displacements.section,
    directors.section,
    density.height_pitch_section,
    density.cell_section,
    statistics.section,
    provenance.section,
)


@dataclass(frozen=True)
class Report:
    """A report that was written."""

    page: Path
    runs: Sequence[Run]
    warnings: Sequence[str]


def report(results: Results | Sequence[Results], out: Path | str) -> Path:
    """Write `report.html` and a folder `figures` of its pictures (SVG, PNG) into the folder `out`; return the page.

    Args:
        results: of one run, or of several to compare: curves are laid over each other.
        out: a folder, made where there is none; an earlier report in it is replaced.

    Raises:
        ResultsError: `out` cannot be written, or there are no results.
    """
    return write_report([results] if isinstance(results, Results) else results, Path(out)).page


def write_report(every: Sequence[Results], out: Path) -> Report:
    """The same, with what the terminal is to say."""
    if not every:
        raise ResultsError("report: found no results, one or more are wanted")
    absolute(out)  # a path that can be written and printed
    out = out.expanduser()
    runs = runs_of(every)
    sections = [make(runs) for make in SECTIONS]
    found = [sentence for run in runs for sentence in run_warnings(run)]
    found += [sentence for section in sections for sentence in section.warnings]
    warnings = _run_by_run(runs, list(dict.fromkeys(found)))
    try:
        (out / FIGURES).mkdir(parents=True, exist_ok=True)
        drawn = [section.name for section in sections if section.draw is not None]
        list_report(out, [PAGE, PAGE + PART, *(f"{FIGURES}/{name}.{kind}" for name in drawn for kind in KINDS)])
        pictures = {
            section.name: write_picture(section.draw(), out / FIGURES, section.name)
            for section in sections
            if section.draw is not None
        }
        part = out / (PAGE + PART)
        part.write_text(html(_title(runs), _lead(runs), sections, pictures, warnings), encoding="utf-8")
        os.replace(part, out / PAGE)
    except OSError as error:
        raise ResultsError(f"{out}: the report cannot be written ({error.strerror})") from error
    return Report(out / PAGE, runs, warnings)


def _run_by_run(runs: Sequence[Run], sentences: Sequence[str]) -> list[str]:
    """In the order of the runs that they are about."""

    def number(sentence: str) -> int:
        return next((i for i, run in enumerate(runs) if sentence.startswith(f"{run.label}: ")), 0)

    return sorted(sentences, key=number)


def _title(runs: Sequence[Run]) -> str:
    return " and ".join(run.label for run in runs) if len(runs) < 4 else f"{runs[0].label} and {len(runs) - 1} others"


def _lead(runs: Sequence[Run]) -> str:
    lead = "; ".join(run.says(_what(run)) for run in runs) + ". Lengths in half-lengths a of a swimmer, times in a/U."
    if scales_of(runs) is None and any(run.scales is not None for run in runs):
        lead += " The runs differ in what these are in the laboratory, so pictures show them alone."
    return lead


def _what(run: Run) -> str:
    info, status = run.results.info, run.results.summary.get("status", "status not known")
    swimmers = counted(info.n_swimmers, "swimmer")
    colloids = own_name(run.results.colloids) or counted(len(run.results.colloids), "colloid")
    parts = [swimmers, colloids, both(info.duration, "a/U", run.scales), status]
    if run.one_in > 1:
        n = len(run.results.stored)
        parts.append(
            f"of {n:,} encounters distributions, fits, means by radius and hops show those of one swimmer in "
            f"{run.one_in}"
        )
    return ", ".join(parts)
