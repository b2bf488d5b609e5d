"""What a run leaves: tables, summary and recording, made of what its observers saw."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pyarrow as pa

from porous_swim.analysis.summary import summarize, summary_page
from porous_swim.core.scales import Scales, with_physical
from porous_swim.core.stopwatch import Stopwatch
from porous_swim.observers.lags import Lags
from porous_swim.obstacles.field import ObstacleField
from porous_swim.results.encounter_table import ENCOUNTERS, Encounters
from porous_swim.results.results import Results
from porous_swim.results.run_folder import RunFolder
from porous_swim.results.tables import (
    COLLOIDS_SCHEMA,
    ENCOUNTERS_SCHEMA,
    LAGS_SCHEMA,
    TRAJECTORY_SCHEMA,
    TableInfo,
    make_table,
)
from porous_swim.running.audience import Audience
from porous_swim.running.outputs import STATISTICS, TRAJECTORY, Outputs, writing
from porous_swim.running.provenance import provenance_of
from porous_swim.running.recorders import Recorders
from porous_swim.running.simulation import Simulation
from porous_swim.scene.identity import portable

Columns = dict[str, np.ndarray]


class Outcome:
    """Makes the results of a run, once."""

    def __init__(
        self, simulation: Simulation, folder: RunFolder | None, outputs: Outputs, recorders: Recorders,
        audience: Audience, watch: Stopwatch, run_id: str,
    ) -> None:  # fmt: skip
        self._simulation, self._folder, self._outputs = simulation, folder, outputs
        self._recorders, self._audience, self._watch, self._run_id = recorders, audience, watch, run_id

    def results(
        self, status: str, *, time: float, rate: float | None, warnings: list[str], signal: str | None = None
    ) -> Results:
        """Tables, summary and recording of a run up to a `time`, a/U; they go into the folder, if there is one.

        Of a `failed` run only encounters that had ended by then are kept.
        """
        provenance = provenance_of(self._simulation) | {"swimmer_steps_per_second": rate, "run_id": self._run_id}
        info = replace(self._simulation.table_info(provenance), last_time=time)
        interrupted = status != "finished"
        outputs = self._outputs
        outputs.check_own()
        outputs.say = False  # the last line will
        with self._watch.timing("recording"):
            stored, tables = self._tables(self._encounters(status, time), info)
        with self._watch.timing("statistics"):
            D_r, dimensions = self._simulation.scene.rotational_diffusion, info.dimensions
            persistence = math.inf if D_r == 0.0 else 1.0 / ((dimensions - 1) * D_r)
            statistics: dict[str, Any] = {"warnings": warnings}
            with outputs.optional(STATISTICS):
                statistics = summarize(
                    stored, *(tables[name] for name in ("colloids", "timeseries", "lags")),
                    persistence_time=persistence, warnings=[*warnings, *_jammed(self._simulation)],
                )  # fmt: skip
        summary: dict[str, Any] = {"status": status, "units": info.units, "provenance": provenance}
        summary["jammed_steps"] = self._simulation.engine.jammed
        summary |= with_physical(statistics, Scales.of(info.units))
        with self._watch.timing("recording"):
            if self._recorders.recording is not None and STATISTICS not in outputs.missing:
                self._recorders.recording.set_summary(summary_page(summary))
        self._audience.dismiss_lost()
        self._audience.finish(own=True, interrupted=interrupted)
        with self._watch.timing("recording"):
            if signal is not None and interrupted:
                summary = {"status": status, "signal": signal} | summary
            results = Results(
                stored, **tables, summary=outputs.tell_missing(summary), folder=None, info=info,
                scene=portable(self._simulation.scene),
            )  # fmt: skip
            if self._folder is not None:
                with writing(self._folder.path):
                    results = self._folder.write_summary(results)
            return results

    def _encounters(self, status: str, time: float) -> Callable[[], Iterator[Columns]]:
        parts = self._simulation.engine.encounter_parts
        return (lambda: (_ended_by(part, time) for part in parts())) if status == "failed" else parts

    def _tables(
        self, encounters: Callable[[], Iterator[Columns]], info: TableInfo
    ) -> tuple[Encounters, dict[str, pa.Table]]:
        """Encounters, and the other tables by name; on disk where there is a folder, what must not be lost first."""
        outputs, folder = self._outputs, self._folder
        tables = {
            "colloids": colloid_table(self._simulation.field, info),
            "timeseries": self._recorders.series.table(info),
            "lags": lag_table(self._recorders.lags, self._simulation, info),
        }
        path = None if folder is None else folder.path / ENCOUNTERS

        def write_encounters() -> Encounters:
            parts = self._told(make_table(ENCOUNTERS_SCHEMA, columns, info=info) for columns in encounters())
            with writing(path):
                return Encounters.written(parts, path)

        nothing = Encounters.in_memory(info.attach(ENCOUNTERS_SCHEMA.empty_table()))
        stored = outputs.require(ENCOUNTERS, write_encounters, nothing)
        self._simulation.engine.close()  # the log is a table now, or there is no room for one: that of the log is free
        outputs.put_table("colloids", tables["colloids"], required=True)
        for name in ("timeseries", "lags"):
            outputs.put_table(name, tables[name])
        trajectory = info.attach(TRAJECTORY_SCHEMA.empty_table())
        if TRAJECTORY not in outputs.missing:
            with outputs.optional(TRAJECTORY):
                self._recorders.trajectory.finish(interrupted=False)
                trajectory = self._recorders.trajectory.table(info)
        return stored, {**tables, "trajectory": trajectory}

    def _told(self, parts: Iterable[pa.Table]) -> Iterator[pa.Table]:
        """Parts of the table of encounters, while the clock tells how many have been taken."""
        n, n_captures = 0, self._simulation.engine.counts()[0]
        for part in parts:
            yield part
            n += len(part)
            self._recorders.clock.tabulate(n / max(n, n_captures, 1))


def _jammed(simulation: Simulation) -> Iterator[str]:
    """Say how often colloids left a swimmer no room."""
    n = simulation.engine.jammed
    if n:
        share = n / max(1, simulation.step * simulation.engine.n_swimmers)
        yield (
            f"In {n:,} steps of swimmers ({100.0 * share:.2g} % of all) three or more colloids left no room for a "
            "swimmer that points as it did: it turned freely, stayed where it was and overlapped them."
        )


def _ended_by(columns: Columns, time: float) -> Columns:
    """Encounters of a run that failed: swimmers stand at different steps, so only what had ended is sure to be whole.

    `time` is that of the last frame.
    """
    seen = ~columns["end_censored"] & (columns["end_time"] <= time)
    return {name: column[seen] for name, column in columns.items()}


def colloid_table(field: ObstacleField, info: TableInfo) -> pa.Table:
    """The colloids as a table."""
    x, y, z = field.centers.T
    columns = dict(colloid=np.arange(len(x)), x=x, y=y, z=z, radius=field.radii)
    return make_table(COLLOIDS_SCHEMA, columns, info=info)


def lag_table(lags: Lags, simulation: Simulation, info: TableInfo) -> pa.Table:
    """Displacements of all swimmers over lags, as a table."""
    columns = lags.columns()
    columns["lag"] = columns["lag"] * simulation.scene.record_period * simulation.scene.run.time_step
    return make_table(LAGS_SCHEMA, columns, info=info)
