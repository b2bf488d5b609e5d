"""Everyone who looks at a run, and the results that they leave."""

from __future__ import annotations

import math
import platform
import time
import uuid
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa

from porous_swim.analysis.summary import summarize, summary_page
from porous_swim.core.scales import Scales, with_physical
from porous_swim.core.stopwatch import Stopwatch
from porous_swim.observers.base import Every, Observer
from porous_swim.observers.progress import make_progress
from porous_swim.observers.rerun.recording import Recording, recording_warning
from porous_swim.observers.timeseries import TimeSeries
from porous_swim.observers.trajectory import Trajectory
from porous_swim.obstacles.field import ObstacleField
from porous_swim.results.encounter_table import ENCOUNTERS, Encounters
from porous_swim.results.manifest import RECORDING
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
from porous_swim.running.outputs import STATISTICS, TRAJECTORY, Outputs, writing
from porous_swim.running.simulation import Simulation
from porous_swim.scene.identity import plugins_of, portable

KEEP_SECONDS = 60.0  # what a killed run may lose of its recording and trajectory
NO_LOCKS = "The file system of the run folder has no locks: nothing keeps a second run out of the folder."
PACKAGES = ("taichi", "numpy", "scipy", "pyarrow", "rerun-sdk", "pydantic")


class Observers:
    """Shows the frames of a run to all observers and makes its results of what they saw."""

    def __init__(
        self, simulation: Simulation, folder: RunFolder | None, watch: Stopwatch, *, progress: bool, recording: bool
    ) -> None:
        scene = simulation.scene
        self._simulation, self._folder, self._watch = simulation, folder, watch
        self.schedule = Every(scene.record_period)
        path = None if folder is None else folder.path
        recorded = np.arange(scene.n_recorded)
        self._series = TimeSeries(self.schedule)
        self._trajectory = Trajectory(self.schedule, swimmers=recorded, path=path and path / TRAJECTORY)
        self.clock = make_progress(
            self.schedule, n_steps=scene.n_steps, n_swimmers=scene.swimmers.count, quiet=not progress,
            seconds=None if scene.unit_system is None else scene.unit_system.time,
        )  # fmt: skip
        self._all: list[Observer] = [self._series, self._trajectory, self.clock]
        self._warnings = scene.warnings(simulation.field)
        self._recording: Recording | None = None
        self._last = -1, 0.0  # step and time of the last frame
        self._run_id = uuid.uuid4().hex if folder is None else folder.run_id
        self._outputs = Outputs(folder, say=progress)
        self._kept, self._ended = time.monotonic(), False
        if folder is not None and not folder.locks:
            self._warnings.append(NO_LOCKS)
        if path is not None and recording:
            self._record(path / RECORDING, recorded)
        if path is not None:
            self._outputs.spare = {TRAJECTORY: self._trajectory, RECORDING: self._recording}

    def observe(self) -> None:
        """Show the present frame to everyone, unless they have seen it."""
        if self._last[0] == self._simulation.step:
            return
        news = self._recording is None or self._recording.wants_news  # without one they are let go, if any are kept
        with self._watch.timing("statistics"):
            everyone = self._simulation.everyone()
        with self._watch.timing("recording"):
            frame = self._simulation.frame(self._simulation.scene.n_recorded, everyone=everyone, news=news)
            self._last = frame.step, frame.time
            for observer in tuple(self._all):
                with self._outputs.optional(self._name_of(observer)):
                    observer.observe(frame)
            self._forget_lost()

    def keep(self) -> None:
        """Write what waits to disk, once a minute: a run that is killed leaves it."""
        if time.monotonic() - self._kept < KEEP_SECONDS:
            return
        self._kept = time.monotonic()
        with self._watch.timing("recording"):
            with self._outputs.optional(TRAJECTORY):
                self._trajectory.keep()
            if self._recording is not None:
                with self._outputs.optional(RECORDING):
                    self._recording.keep()
            self._forget_lost()

    def finish(self, *, interrupted: bool) -> None:
        """Let everyone close what is open."""
        for observer in self._all:
            observer.finish(interrupted=interrupted)

    def results(self, *, rate: float | None, signal: str | None = None) -> Results:
        """Tables, summary and recording of a run that came to its end or was interrupted, by the `signal` of this name.

        RunError where a file could not be written: the others are there, and the summary says which one is not.
        """
        simulation = self._simulation
        interrupted = simulation.step < simulation.scene.n_steps
        if self._recording is not None and self._recording.is_behind:
            self._recording.catch_up(simulation.frame(simulation.scene.n_recorded))
        results = self._results(
            "interrupted" if interrupted else "finished", simulation.engine.encounter_parts,
            time=simulation.time, rate=rate, warnings=self._warnings, signal=signal,
        )  # fmt: skip
        self._outputs.complain()
        return results

    def rescue(self, error: Exception) -> None:
        """Keep what was seen before a run failed; where even that fails, the run's own error is what matters."""
        if self._ended:
            return
        time = self._last[1]
        missing = f"The run failed after time {time:g} a/U; encounters under way then are missing. ({error})"
        with suppress(Exception):
            self._results(
                "failed", lambda: (_ended_by(part, time) for part in self._simulation.engine.encounter_parts()),
                time=time, rate=None, warnings=[missing, *self._warnings],
            )  # fmt: skip

    def _results(
        self, status: str, encounters: Callable[[], Iterator[dict[str, np.ndarray]]], *, time: float,
        rate: float | None, warnings: list[str], signal: str | None = None,
    ) -> Results:  # fmt: skip
        provenance = provenance_of(self._simulation) | {"swimmer_steps_per_second": rate, "run_id": self._run_id}
        info = replace(self._simulation.table_info(provenance), last_time=time)
        interrupted = status != "finished"
        outputs = self._outputs
        outputs.check_own()
        outputs.say = False  # the last line will
        with self._watch.timing("recording"):
            stored, tables = self._tables(encounters, info)
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
            self._forget_lost()
            if self._recording is not None and STATISTICS not in outputs.missing:
                self._recording.set_summary(summary_page(summary))
            for observer in tuple(self._all):
                with outputs.optional(self._name_of(observer)):
                    observer.finish(interrupted=interrupted)
            if signal is not None and interrupted:
                summary = {"status": status, "signal": signal} | summary
            results = Results(
                stored, **tables, summary=outputs.tell_missing(summary), folder=None, info=info,
                scene=portable(self._simulation.scene),
            )  # fmt: skip
            if self._folder is not None:
                with writing(self._folder.path):
                    results = self._folder.write_summary(results)
            self._ended = True
            return results

    def _tables(
        self, encounters: Callable[[], Iterator[dict[str, np.ndarray]]], info: TableInfo
    ) -> tuple[Encounters, dict[str, pa.Table]]:
        """Encounters, and the other tables by name; on disk where there is a folder, what must not be lost first."""
        outputs, folder = self._outputs, self._folder
        tables = {
            "colloids": colloid_table(self._simulation.field, info),
            "timeseries": self._series.table(info),
            "lags": lag_table(self._simulation, info),
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
                self._trajectory.finish(interrupted=False)
                trajectory = self._trajectory.table(info)
        return stored, {**tables, "trajectory": trajectory}

    def _told(self, parts: Iterable[pa.Table]) -> Iterator[pa.Table]:
        """Parts of the table of encounters, while the clock tells how many have been taken."""
        n, n_captures = 0, self._simulation.engine.counts()[0]
        for part in parts:
            yield part
            n += len(part)
            self.clock.tabulate(n / max(n, n_captures, 1))

    def _name_of(self, observer: Observer) -> str:
        """The file of an observer; empty for one that has none."""
        return {id(self._trajectory): TRAJECTORY, id(self._recording): RECORDING}.get(id(observer), "")

    def _forget_lost(self) -> None:
        """Show nothing more to those whose file was lost."""
        self._all = [observer for observer in self._all if self._name_of(observer) not in self._outputs.missing]
        if RECORDING in self._outputs.missing:
            self._recording = None

    def _record(self, path: Path, recorded: np.ndarray) -> None:
        scene, field = self._simulation.scene, self._simulation.field
        units = scene.unit_system
        n_frames = scene.n_steps // scene.record_period + 1
        too_large = recording_warning(
            n_frames=n_frames, n_swimmers=len(recorded), n_trails=scene.n_trails, rods=scene.swimmers.aspect_ratio < 1.0
        )
        self._warnings += [] if too_large is None else [too_large]
        self._recording = Recording(
            path, self.schedule, field, name=scene.name, description=scene.description,
            recording_id=f"{scene.scene_id}-{scene.run.seed}", time_step=scene.run.time_step, n_steps=scene.n_steps,
            aspect_ratio=scene.swimmers.aspect_ratio, swimmers=recorded, trails=recorded[: scene.n_trails],
            provenance=provenance_of(self._simulation), units=None if units is None else (units.length, units.time),
        )  # fmt: skip
        self._all.append(self._recording)


def _jammed(simulation: Simulation) -> Iterator[str]:
    """Say how often colloids left a swimmer no room."""
    n = simulation.engine.jammed
    if n:
        share = n / max(1, simulation.step * simulation.engine.n_swimmers)
        yield (
            f"In {n:,} steps of swimmers ({100.0 * share:.2g} % of all) three or more colloids left no room for a "
            "swimmer that points as it did: it turned freely, stayed where it was and overlapped them."
        )


def _ended_by(columns: dict[str, np.ndarray], time: float) -> dict[str, np.ndarray]:
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


def lag_table(simulation: Simulation, info: TableInfo) -> pa.Table:
    """Displacements of all swimmers over lags, as a table."""
    columns = simulation.lags.columns()
    columns["lag"] = columns["lag"] * simulation.scene.record_period * simulation.scene.run.time_step
    return make_table(LAGS_SCHEMA, columns, info=info)


def provenance_of(simulation: Simulation) -> dict[str, Any]:
    """What made a run: enough to make it again."""
    scene = simulation.scene
    return {
        "version": version("porous_swim"), "scene": scene.name, "scene_id": scene.scene_id, "seed": scene.run.seed,
        "device": simulation.backend.device, "precision": scene.precision, "threads": simulation.backend.threads,
        "python": platform.python_version(), "packages": {name: version(name) for name in PACKAGES} | plugins_of(scene),
    }  # fmt: skip
