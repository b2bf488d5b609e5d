"""What to mind about a run as a whole; sections add what they find."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from porous_swim.analysis.columns import column
from porous_swim.reporting.run import Run

STEADY = 4.0  # standard errors between the third and the last quarter


def run_warnings(run: Run) -> list[str]:
    """The warnings of the summary, and what its time series gives rise to."""
    return [run.says(sentence) for sentence in (*_status(run), *run.results.summary.get("warnings", ()), *_series(run))]


def _status(run: Run) -> Iterator[str]:
    status = run.results.summary.get("status")
    if status != "finished":
        yield f"The run is {status}: it ends at time {run.results.info.last_time:g} a/U, and so do all statistics."


def _series(run: Run) -> Iterator[str]:
    series = run.results.timeseries
    if len(series) < 8:
        return
    time, bound, escapes = (column(series, name) for name in ("time", "fraction_bound", "n_escapes"))
    late = np.searchsorted(time, 0.5 * time[-1])
    if bound[-1] == 1.0 and escapes[-1] == escapes[late]:
        yield (
            f"All swimmers are stuck: each is at a colloid at the end, and none has left one since time {time[late]:g} "
            "a/U. Late statistics say nothing of transport."
        )
        return
    # Frames share swimmers: the error of a quarter's mean is no more than that of one frame.
    third, last = (float(np.mean(quarter)) for quarter in np.array_split(bound, 4)[2:])
    mean = 0.5 * (third + last)
    error = np.sqrt(2.0 * mean * (1.0 - mean) / max(run.results.info.n_swimmers, 1))
    if abs(last - third) > STEADY * error > 0.0:
        yield (
            f"The fraction bound still changes: {third:.3f} in the third quarter of the run, {last:.3f} in the last. "
            "Averages over the run depend on how it began: record.burn_in leaves its start out of them."
        )
