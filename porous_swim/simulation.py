"""One run: a scene goes in, a run folder and `Results` come out."""

from __future__ import annotations

import math
import platform
import signal
import time
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from porous_swim.analysis.summary import summarize, summary_page
from porous_swim.engine import backend
from porous_swim.engine.engine import Engine, Laws, Numbers
from porous_swim.engine.probe import height_at_sine
from porous_swim.observers.base import BOUND, CONTACT, FREE, Counts, Every, Frame, Observer
from porous_swim.observers.progress import make_progress
from porous_swim.observers.recording import Recording, recording_warning
from porous_swim.observers.timeseries import TimeSeries
from porous_swim.observers.trajectory import Trajectory
from porous_swim.obstacles.field import ObstacleField
from porous_swim.physics.noise import Brownian
from porous_swim.results import COLLOIDS_SCHEMA, ENCOUNTERS_SCHEMA, Results, RunFolder, TableInfo, make_table
from porous_swim.scene import Scene

LOOK_SECONDS = 0.5  # between looks at the keyboard and at the clock; decides no result
PACKAGES = ("porous_swim", "taichi", "numpy", "scipy", "pyarrow", "rerun-sdk", "pydantic")


class Simulation:
    """A scene placed on a device: advance it with `run`, or step by step with `advance` and look at `frame`."""

    def __init__(self, scene: Scene) -> None:
        """Place colloids and swimmers and compile the kernel. SceneError, DeviceError as the scene deserves."""
        self.scene = scene
        self.backend = backend.ensure(scene.run.device, scene.run.threads)
        self.field: ObstacleField = scene.place_obstacles()
        gamma = scene.swimmers.aspect_ratio
        swimmers = scene.place_swimmers(self.field, lambda s, A: height_at_sine(s, A, aspect_ratio=gamma))
        noise = scene.noise
        self.engine = Engine(
            self.backend, self.field, swimmers.position, swimmers.director, laws=laws_of(scene),
            numbers=Numbers(
                scene.run.time_step, scene.encounter.escape_height, scene.encounter.contact_band, scene.run.seed
            ),
            hydrodynamics=type(scene.hydrodynamics), precision=scene.precision,
            variates=noise.variates if isinstance(noise, Brownian) else None,
        )  # fmt: skip

    @property
    def step(self) -> int:
        """Steps made so far."""
        return self.engine.step

    @property
    def time(self) -> float:
        """Time reached, a/U."""
        return self.step * self.scene.run.time_step

    def advance(self, n_steps: int) -> None:
        """Move all swimmers by `n_steps`. RunError where a swimmer cannot go on."""
        self.engine.advance(n_steps)

    def frame(self) -> Frame:
        """All swimmers as they are now, and what ended since the last frame."""
        now, ended = self.engine.snapshot(), self.engine.ended()
        least = height_at_sine(now.pitch_sine, 1.0, aspect_ratio=self.scene.swimmers.aspect_ratio)
        low = now.height <= least + self.scene.encounter.contact_band
        state = np.where(now.bound, np.where(low, CONTACT, BOUND), FREE).astype(np.uint8)
        return Frame(
            step=self.step, time=self.time, position=now.position, director=now.director, colloid=now.colloid,
            image=now.image, state=state, counts=Counts(*self.engine.counts()),
            residence=ended.residence, winding=ended.winding, hop_time=ended.hop_time,
        )  # fmt: skip

    def table_info(self, provenance: dict[str, Any]) -> TableInfo:
        """What holds for all tables of this run, as of now."""
        units = self.scene.unit_system
        return TableInfo(
            n_swimmers=self.engine.n_swimmers, dimensions=self.field.dimensions, box=tuple(self.field.box.tolist()),
            first_time=0.0, last_time=self.time, time_step=self.scene.run.time_step, provenance=provenance,
            units=None if units is None else {"length_um": units.length, "time_s": units.time},
        )  # fmt: skip


def laws_of(scene: Scene) -> Laws:
    """The parameter set of a scene; one row."""
    alpha, gamma = scene.swimmers.dipole_strength, scene.swimmers.aspect_ratio
    numbers = (
        alpha, gamma, scene.translational_diffusion, scene.rotational_diffusion,
        scene.encounter.escape_sine(alpha, gamma),
    )  # fmt: skip
    return Laws(*(np.array([number]) for number in numbers))


def run(
    scene: Scene, *, out: Path | str | None = None, overwrite: bool = False, progress: bool = False,
    recording: bool = True,
) -> Results:  # fmt: skip
    """Run a scene to its end and return its results.

    Args:
        scene: what to run.
        out: the run folder; None keeps everything in memory, without a recording.
        overwrite: allow `out` to hold an earlier run, whose files are replaced.
        progress: show a bar on stderr.
        recording: write `recording.rrd`.

    Raises:
        SceneError: colloids overlap or swimmers do not fit.
        DeviceError: the device of the scene is not here.
        ResultsError: `out` is not empty, or cannot be written.
        RunError: a swimmer could not go on, or the disk is full.

    An interrupt (Ctrl-C, SIGTERM) ends the run at the next look; the results say `interrupted`.
    """
    folder = None if out is None else RunFolder.at(out, overwrite=overwrite)
    return run_in(scene, folder, progress=progress, recording=recording)


def run_in(scene: Scene, folder: RunFolder | None, *, progress: bool, recording: bool = True) -> Results:
    """The same, in a run folder that has been made."""
    with _interrupts() as interrupted:
        simulation = Simulation(scene)
        if folder is not None:
            scene.save(folder.path)
        observers = Observers(simulation, folder, progress=progress, recording=recording)
        try:
            rate = _advance(simulation, observers, interrupted)
        except BaseException:
            observers.finish(interrupted=True)
            raise
        return observers.results(rate=rate, interrupted=simulation.step < scene.n_steps)


class Observers:
    """Everyone who looks at a run, and what they make of it."""

    def __init__(self, simulation: Simulation, folder: RunFolder | None, *, progress: bool, recording: bool) -> None:
        scene = simulation.scene
        self._simulation, self._folder = simulation, folder
        self.schedule = Every(scene.record_period)
        path = None if folder is None else folder.path
        recorded = np.arange(scene.n_recorded)
        self.series = TimeSeries(self.schedule)
        self.trajectory = Trajectory(self.schedule, swimmers=recorded, path=path and path / "trajectory.parquet")
        self.clock = make_progress(
            self.schedule, n_steps=scene.n_steps, n_swimmers=scene.swimmers.count, quiet=not progress
        )
        self.all: list[Observer] = [self.series, self.trajectory, self.clock]
        self.warnings = scene.warnings(simulation.field)
        self.recording: Recording | None = None
        if path is not None and recording:
            self._record(path / "recording.rrd", recorded)

    def observe(self) -> None:
        """Show the present frame to everyone."""
        frame = self._simulation.frame()
        for observer in self.all:
            observer.observe(frame)

    def finish(self, *, interrupted: bool) -> None:
        """Let everyone close what is open."""
        for observer in self.all:
            observer.finish(interrupted=interrupted)

    def results(self, *, rate: float | None, interrupted: bool) -> Results:
        """Tables, summary and recording of the run, written where there is a folder."""
        simulation, scene = self._simulation, self._simulation.scene
        status = "interrupted" if interrupted else "finished"
        provenance = provenance_of(simulation) | {"swimmer_steps_per_second": rate}
        info = simulation.table_info(provenance)
        encounters = make_table(ENCOUNTERS_SCHEMA, simulation.engine.encounters(), info=info)
        colloids = colloid_table(simulation.field, info)
        series, trajectory = self.series.table(info), None
        D_r = scene.rotational_diffusion
        persistence = math.inf if D_r == 0.0 else 1.0 / ((simulation.field.dimensions - 1) * D_r)
        self.trajectory.finish(interrupted=interrupted)
        trajectory = self.trajectory.table(info)
        summary = {"status": status, "provenance": provenance} | summarize(
            encounters, colloids, series, trajectory, persistence_time=persistence, warnings=self.warnings
        )
        if self.recording is not None:
            self.recording.set_summary(summary_page(summary))
        self.finish(interrupted=interrupted)
        results = Results(encounters, colloids, series, trajectory, summary, None, info)
        return results if self._folder is None else self._folder.write(results)

    def _record(self, path: Path, recorded: np.ndarray) -> None:
        scene, field = self._simulation.scene, self._simulation.field
        units = scene.unit_system
        n_frames = scene.n_steps // scene.record_period + 1
        too_large = recording_warning(n_frames=n_frames, n_swimmers=len(recorded), n_trails=scene.n_trails)
        self.warnings += [] if too_large is None else [too_large]
        self.recording = Recording(
            path, self.schedule, field, name=scene.name, description=scene.description,
            recording_id=f"{scene.scene_id}-{scene.run.seed}", time_step=scene.run.time_step, n_steps=scene.n_steps,
            swimmer_radius=scene.swimmers.aspect_ratio, swimmers=recorded, trails=recorded[: scene.n_trails],
            provenance=provenance_of(self._simulation), units=None if units is None else (units.length, units.time),
        )  # fmt: skip
        self.all.append(self.recording)


def _advance(simulation: Simulation, observers: Observers, interrupted: list[int]) -> float | None:
    """Run to the end or to an interrupt; return swimmer-steps per second, the first launch (compiling) left out."""
    end, schedule = simulation.scene.n_steps, observers.schedule
    observers.observe()
    simulation.advance(1)
    observers.clock.start(step=simulation.step)
    begin = last = time.perf_counter()
    first, at_once = simulation.step, 1
    while simulation.step < end and not interrupted:
        due = min(schedule.next_step(simulation.step), end)
        simulation.advance(min(at_once, due - simulation.step))
        now = time.perf_counter()
        at_once = _next_launch(at_once, now - last)
        last = now
        if simulation.step == due:
            observers.observe()
            last = time.perf_counter()
    if first == end or (interrupted and simulation.step % schedule.period):
        observers.observe()
    steps = (simulation.step - first) * simulation.engine.n_swimmers
    return steps / (time.perf_counter() - begin) if steps > 0 else None


def _next_launch(steps: int, seconds: float) -> int:
    """Launches grow until they take about as long as a user may wait; results do not depend on them."""
    if seconds < 0.5 * LOOK_SECONDS:
        return min(2 * steps, 1 << 30)
    return max(1, steps // 2) if seconds > LOOK_SECONDS else steps


def colloid_table(field: ObstacleField, info: TableInfo) -> Any:
    """The colloids as a table."""
    x, y, z = field.centers.T
    columns = dict(colloid=np.arange(len(x)), x=x, y=y, z=z, radius=field.radii)
    return make_table(COLLOIDS_SCHEMA, columns, info=info)


def provenance_of(simulation: Simulation) -> dict[str, Any]:
    """What made a run: enough to make it again."""
    scene = simulation.scene
    return {
        "version": version("porous_swim"), "scene": scene.name, "scene_id": scene.scene_id, "seed": scene.run.seed,
        "device": simulation.backend.device, "precision": scene.precision, "threads": simulation.backend.threads,
        "python": platform.python_version(), "packages": {name: version(name) for name in PACKAGES[1:]},
    }  # fmt: skip


@contextmanager
def _interrupts() -> Iterator[list[int]]:
    """A list that Ctrl-C and SIGTERM append to. A second Ctrl-C interrupts at once."""
    seen: list[int] = []

    def note(number: int, _frame: object) -> None:
        if seen:
            raise KeyboardInterrupt
        seen.append(number)

    try:
        before = {number: signal.signal(number, note) for number in (signal.SIGINT, signal.SIGTERM)}
    except ValueError:  # not in the main thread, which alone may handle signals
        yield seen
        return
    try:
        yield seen
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
