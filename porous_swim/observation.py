"""Everyone who looks at a run, and the results that they leave."""

from __future__ import annotations

import math
import platform
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pyarrow as pa

from porous_swim.analysis.summary import summarize, summary_page
from porous_swim.encounters import ENCOUNTERS, Encounters
from porous_swim.errors import RunError
from porous_swim.observers.base import Every, Observer
from porous_swim.observers.progress import make_progress
from porous_swim.observers.recording import Recording, recording_warning
from porous_swim.observers.timeseries import TimeSeries
from porous_swim.observers.trajectory import Trajectory
from porous_swim.obstacles.field import ObstacleField
from porous_swim.results import Results, RunFolder
from porous_swim.scene_identity import portable
from porous_swim.stopwatch import Stopwatch
from porous_swim.tables import COLLOIDS_SCHEMA, ENCOUNTERS_SCHEMA, LAGS_SCHEMA, TableInfo, make_table

if TYPE_CHECKING:
    from porous_swim.simulation import Simulation

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
        self._trajectory = Trajectory(self.schedule, swimmers=recorded, path=path and path / "trajectory.parquet")
        self.clock = make_progress(
            self.schedule, n_steps=scene.n_steps, n_swimmers=scene.swimmers.count, quiet=not progress
        )
        self._all: list[Observer] = [self._series, self._trajectory, self.clock]
        self._warnings = scene.warnings(simulation.field)
        self._recording: Recording | None = None
        self._last = -1, 0.0  # step and time of the last frame
        if path is not None and recording:
            self._record(path / "recording.rrd", recorded)

    def observe(self) -> None:
        """Show the present frame to everyone, unless they have seen it."""
        if self._last[0] == self._simulation.step:
            return
        news = self._recording is not None and self._recording.wants_news
        with self._watch.timing("statistics"):
            everyone = self._simulation.everyone()
        with self._watch.timing("recording"):
            frame = self._simulation.frame(self._simulation.scene.n_recorded, everyone=everyone, news=news)
            self._last = frame.step, frame.time
            for observer in self._all:
                observer.observe(frame)

    def finish(self, *, interrupted: bool) -> None:
        """Let everyone close what is open."""
        for observer in self._all:
            observer.finish(interrupted=interrupted)

    def results(self, *, rate: float | None) -> Results:
        """Tables, summary and recording of a run that came to its end or was interrupted."""
        simulation = self._simulation
        interrupted = simulation.step < simulation.scene.n_steps
        if self._recording is not None and self._recording.is_behind:
            self._recording.catch_up(simulation.frame(simulation.scene.n_recorded))
        return self._results(
            "interrupted" if interrupted else "finished", simulation.engine.encounter_parts(),
            time=simulation.time, rate=rate, warnings=self._warnings,
        )  # fmt: skip

    def rescue(self, error: RunError) -> None:
        """Keep what was seen before a run failed; where even that fails, the run's own error is what matters."""
        time = self._last[1]
        missing = f"The run failed after time {time:g} a/U; encounters under way then are missing. ({error})"
        with suppress(Exception):
            parts = (_ended_by(part, time) for part in self._simulation.engine.encounter_parts())
            self._results("failed", parts, time=time, rate=None, warnings=[missing, *self._warnings])
            return
        with suppress(Exception):  # without them, and with the room on the disk that they took
            self._simulation.engine.close()
            lost = "The encounters of the run could not be written and are missing, and statistics of them too."
            nothing = {field.name: np.zeros(0, field.type.to_pandas_dtype()) for field in ENCOUNTERS_SCHEMA}
            self._results("failed", iter([nothing]), time=time, rate=None, warnings=[missing, lost, *self._warnings])

    def _results(
        self, status: str, encounters: Iterator[dict[str, np.ndarray]], *, time: float, rate: float | None,
        warnings: list[str],
    ) -> Results:  # fmt: skip
        provenance = provenance_of(self._simulation) | {"swimmer_steps_per_second": rate}
        info = replace(self._simulation.table_info(provenance), last_time=time)
        interrupted = status != "finished"
        with self._watch.timing("recording"):
            self._trajectory.finish(interrupted=interrupted)
            stored, tables = self._tables(encounters, info)
        with self._watch.timing("statistics"):
            D_r, dimensions = self._simulation.scene.rotational_diffusion, info.dimensions
            persistence = math.inf if D_r == 0.0 else 1.0 / ((dimensions - 1) * D_r)
            statistics = summarize(
                stored, *(tables[name] for name in ("colloids", "timeseries", "lags")),
                persistence_time=persistence, warnings=[*warnings, *_jammed(self._simulation)],
            )  # fmt: skip
        jammed = {"jammed_steps": self._simulation.engine.jammed}
        summary = {"status": status, "units": info.units, "provenance": provenance} | jammed | statistics
        with self._watch.timing("recording"):
            if self._recording is not None:
                self._recording.set_summary(summary_page(summary))
            self.finish(interrupted=interrupted)
            results = Results(
                stored, **tables, summary=summary, folder=None, info=info, scene=portable(self._simulation.scene)
            )
            if self._folder is None:
                return results
            with _writing(self._folder.path):
                return self._folder.write_summary(results)

    def _tables(
        self, encounters: Iterator[dict[str, np.ndarray]], info: TableInfo
    ) -> tuple[Encounters, dict[str, pa.Table]]:
        """Encounters, and the other tables by name; on disk where there is a folder."""
        parts = self._told(make_table(ENCOUNTERS_SCHEMA, columns, info=info) for columns in encounters)
        path = None if self._folder is None else self._folder.path / ENCOUNTERS
        with _writing(path):
            stored = Encounters.written(parts, path)
        tables = {
            "colloids": colloid_table(self._simulation.field, info),
            "timeseries": self._series.table(info),
            "lags": lag_table(self._simulation, info),
        }
        if self._folder is not None:
            with _writing(self._folder.path):
                self._folder.write_tables(tables)
        return stored, {**tables, "trajectory": self._trajectory.table(info)}  # which writes itself

    def _told(self, parts: Iterable[pa.Table]) -> Iterator[pa.Table]:
        """Parts of the table of encounters, while the clock tells how many have been taken."""
        n, n_captures = 0, self._simulation.engine.counts()[0]
        for part in parts:
            yield part
            n += len(part)
            self.clock.tabulate(n / max(n, n_captures, 1))

    def _record(self, path: Path, recorded: np.ndarray) -> None:
        scene, field = self._simulation.scene, self._simulation.field
        units = scene.unit_system
        n_frames = scene.n_steps // scene.record_period + 1
        too_large = recording_warning(n_frames=n_frames, n_swimmers=len(recorded), n_trails=scene.n_trails)
        self._warnings += [] if too_large is None else [too_large]
        self._recording = Recording(
            path, self.schedule, field, name=scene.name, description=scene.description,
            recording_id=f"{scene.scene_id}-{scene.run.seed}", time_step=scene.run.time_step, n_steps=scene.n_steps,
            swimmer_radius=scene.swimmers.aspect_ratio, swimmers=recorded, trails=recorded[: scene.n_trails],
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


@contextmanager
def _writing(path: Path | None) -> Iterator[None]:
    """Say which tables the disk has no room for."""
    try:
        yield
    except OSError as error:
        raise RunError(f"{path}: the tables cannot be written: {error.strerror or error}") from None


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
        "python": platform.python_version(), "packages": {name: version(name) for name in PACKAGES},
    }  # fmt: skip
