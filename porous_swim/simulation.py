"""One run: a scene goes in, a run folder and `Results` come out."""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from porous_swim.costs import compiling_seconds
from porous_swim.encounters import ROWS
from porous_swim.engine import backend
from porous_swim.engine.backend import Backend
from porous_swim.engine.engine import Engine
from porous_swim.engine.lags import Lags, n_levels
from porous_swim.engine.laws import Laws, Numbers
from porous_swim.engine.news import News
from porous_swim.engine.probe import height_at_sine
from porous_swim.engine.survey import Groups
from porous_swim.errors import RunError
from porous_swim.footprint import require_memory
from porous_swim.interrupts import Interrupts
from porous_swim.observation import Observers
from porous_swim.observers.base import BOUND, CONTACT, FREE, Counts, Ensemble, Frame
from porous_swim.obstacles.field import ObstacleField
from porous_swim.physics.noise import Brownian
from porous_swim.printing import tell
from porous_swim.results import Results
from porous_swim.run_folder import RunFolder
from porous_swim.scene import Scene
from porous_swim.scene_identity import copies
from porous_swim.stopwatch import Stopwatch
from porous_swim.swarm import Swimmers
from porous_swim.tables import TableInfo

LOOK_SECONDS = 0.5  # between looks at the keyboard and at the clock; decides no result


@dataclass(frozen=True, eq=False)
class Start:
    """A device that runs, and what stands at t = 0: all that can fail by the user's hand, and quick to make."""

    backend: Backend
    field: ObstacleField
    swimmers: Swimmers

    @classmethod
    def of(cls, scene: Scene) -> Start:
        """Start the device and place colloids and swimmers. SceneError, DeviceError as the scene deserves."""
        started = backend.ensure(scene.run.device, scene.run.threads)
        field = scene.place_obstacles()
        gamma = scene.swimmers.aspect_ratio
        return cls(started, field, scene.place_swimmers(field, lambda s, A: height_at_sine(s, A, aspect_ratio=gamma)))


class Simulation:
    """A scene placed on a device: advance it step by step with `advance` and look at `frame`."""

    def __init__(
        self, scene: Scene, start: Start | None = None, *, lanes: int | None = None, news: bool = True,
        log_path: Path | None = None,
    ) -> None:  # fmt: skip
        """Compile the kernel for a scene and its start, by default `Start.of(scene)`.

        `lanes` is the number of swimmers to a block; it changes the speed only. `news` keeps what frames tell of the
        encounters since the last. Many encounters wait in the file `log_path`, without one in memory.
        """
        start = Start.of(scene) if start is None else start
        self.scene, self.backend, self.field, self._keeps_news = scene, start.backend, start.field, news
        noise = scene.noise
        self.engine = Engine(
            self.backend, self.field, start.swimmers.position, start.swimmers.director, laws=laws_of(scene),
            numbers=Numbers(
                scene.run.time_step, scene.encounter.escape_height, scene.encounter.contact_band, scene.run.seed,
                scene.flight_ticks,
            ),
            hydrodynamics=type(scene.hydrodynamics), precision=scene.precision, integrator=scene.integrator,
            variates=noise.variates if isinstance(noise, Brownian) else None, lanes=lanes, news=news, log_path=log_path,
        )  # fmt: skip
        frames = {"n_frames": scene.n_frames, "burn_in": scene.burn_in_frames}
        self._survey = self.engine.survey(n_levels=n_levels(**frames))
        self.lags = Lags(self._survey, period=scene.record_period, **frames)

    @property
    def step(self) -> int:
        """Steps made so far."""
        return self.engine.step

    @property
    def time(self) -> float:
        """Time reached, a/U."""
        return self.step * self.scene.run.time_step

    def advance(self, n_steps: int) -> None:
        """Move all swimmers by `n_steps`, whole flights of them. RunError where a swimmer cannot go on."""
        self.engine.advance(n_steps)

    def everyone(self) -> Ensemble:
        """All swimmers together as they are now; takes in their displacements over lags, too, where a frame is due."""
        return _ensemble(self.lags.note(self.step))

    def frame(self, n: int | None = None, *, everyone: Ensemble | None = None, news: bool | None = None) -> Frame:
        """The first `n` swimmers as they are now, by default all, and what is new since the last frame with `news`.

        `everyone` is what `everyone()` says, where that has been asked already; `news` is by default what the
        simulation keeps.
        """
        news = self._keeps_news if news is None else news and self._keeps_news
        everyone = self.everyone() if everyone is None else everyone
        now = self.engine.snapshot(n)
        new, under_way = self.engine.news() if news else (News.joined([]), np.zeros(0))
        least = height_at_sine(now.pitch_sine, now.radius, aspect_ratio=self.scene.swimmers.aspect_ratio)
        low = now.height <= least + max(self.scene.encounter.contact_band, self.engine.tolerance)
        state = np.where(now.bound, np.where(low, CONTACT, BOUND), FREE).astype(np.uint8)
        return Frame(
            step=self.step, time=self.time, position=now.position, director=now.director, colloid=now.colloid,
            image=now.image, state=state, ensemble=everyone, has_colloids=len(self.field.radii) > 0,
            counts=Counts(*self.engine.counts()),
            residence=new.residence, winding=new.winding, hop_time=new.hop_time, hops=new.hops,
            under_way=under_way * self.scene.run.time_step, has_news=news,
        )  # fmt: skip

    def table_info(self, provenance: dict[str, Any]) -> TableInfo:
        """What holds for all tables of this run, as of now."""
        scene, units = self.scene, self.scene.unit_system
        return TableInfo(
            n_swimmers=self.engine.n_swimmers, dimensions=self.field.dimensions, box=tuple(self.field.box.tolist()),
            first_time=0.0, last_time=self.time, time_step=scene.run.time_step, provenance=provenance,
            units=None if units is None else {"length_um": units.length, "time_s": units.time},
            burn_in=scene.record.burn_in, spacing=self.field.spacing,
        )  # fmt: skip


def _ensemble(groups: Groups) -> Ensemble:
    """All swimmers together, from sums over groups of them."""
    n = int(groups.n.sum())
    msd = float(groups.n @ groups.square) / n
    squares = float(np.sum(groups.spread + groups.n * (groups.square - msd) ** 2))
    error = math.sqrt(squares / ((n - 1) * n)) if n > 1 else math.nan
    return Ensemble(n, float(groups.bound.sum()) / n, float(groups.contact.sum()) / n, msd, error)


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
    recording: bool = True, force_memory: bool = False,
) -> Results:  # fmt: skip
    """Run a scene to its end and return its results.

    Args:
        scene: what to run.
        out: the run folder; None keeps everything in memory, without a recording.
        overwrite: allow `out` to hold an earlier run, whose files are replaced; no other file is touched.
        progress: say on stderr how far the run is.
        recording: write `recording.rrd`.
        force_memory: start even where the run is expected to need more memory than there is.

    Raises:
        SceneError: colloids overlap, swimmers do not fit, or the run does not fit into memory.
        DeviceError: the device of the scene is not here.
        ResultsError: `out` is not empty, another run is under way in it, or it cannot be written.
        RunError: a swimmer could not go on, or a file could not be written; `out` keeps what was seen, as far as it
            can, and its summary says what is missing.

    An interrupt (Ctrl-C, SIGTERM, SIGHUP) ends the run at the next look; the results say `interrupted`.
    """
    say = (lambda line: tell(line, sys.stderr)) if progress else None
    return run_in(
        lambda: (
            None if out is None else RunFolder.at(out, overwrite=overwrite, inputs=scene.inputs, say=say)
        ),
        scene=scene, progress=progress, recording=recording, force_memory=force_memory,
    )  # fmt: skip


def run_in(
    make_folder: Callable[[], RunFolder | None], *, scene: Scene, progress: bool, recording: bool = True,
    force_memory: bool = False,
) -> Results:  # fmt: skip
    """The same in a folder that is made only when the scene is known to start, so that a mistake costs no old run."""
    watch = Stopwatch()
    with Interrupts() as interrupts, ExitStack() as stack:
        if not force_memory:
            require_memory(scene)
        with watch.timing("placing"):
            start = Start.of(scene)
        folder = make_folder()
        if folder is not None:
            stack.enter_context(folder)
            _save_scene(scene, folder)
        if progress:
            tell(_device_line(scene, start.backend), sys.stderr)
        with interrupts.while_compiling(), watch.timing("compiling"):
            recording = recording and folder is not None
            log_path = None if folder is None else folder.path / ROWS
            simulation = Simulation(scene, start, news=recording, log_path=log_path)
        stack.callback(simulation.engine.close)
        observers = Observers(simulation, folder, watch, progress=progress, recording=recording)
        try:
            rate = _advance(simulation, observers, interrupts, watch)
            results = observers.results(rate=rate, signal=interrupts.name)
        except Exception as error:
            observers.rescue(error)
            raise
        except BaseException:
            observers.finish(interrupted=True)
            raise
        if progress:
            tell(watch.line(), sys.stderr)
        return results


def _advance(simulation: Simulation, observers: Observers, interrupts: Interrupts, watch: Stopwatch) -> float | None:
    """Run to the end or to an interrupt; return swimmer-steps per second."""
    end, schedule = simulation.scene.n_steps, observers.schedule
    watch.seconds["swimming"] = 0.0  # told before what the first look takes
    observers.observe()
    observers.clock.start(step=0)
    begin, at_once = time.perf_counter(), simulation.scene.flight_ticks
    while simulation.step < end and not interrupts:
        due = min(schedule.next_step(simulation.step), end)
        last = time.perf_counter()
        with watch.timing("swimming"):
            simulation.advance(min(at_once, due - simulation.step))
        at_once = _next_launch(at_once, time.perf_counter() - last, unit=simulation.scene.flight_ticks)
        if simulation.step == due:
            observers.observe()
        observers.keep()
    observers.observe()  # an interrupt may come between two frames
    observers.clock.end(interrupted=simulation.step < end)
    steps = simulation.step * simulation.engine.n_swimmers
    return steps / (time.perf_counter() - begin) if steps > 0 else None


def _next_launch(steps: int, seconds: float, *, unit: int) -> int:
    """Launches grow until they take about as long as a user may wait; results do not depend on them."""
    if seconds < 0.5 * LOOK_SECONDS:
        return min(2 * steps, (1 << 30) // unit * unit)
    return max(1, steps // (2 * unit)) * unit if seconds > LOOK_SECONDS else steps


def _device_line(scene: Scene, started: Backend) -> str:
    """What computes and why, while the user waits for the compiler."""
    device = started.device.upper() if started.device in ("cpu", "cuda") else started.device.capitalize()
    why = ", as no CUDA or Metal device was found" if scene.run.device == "auto" and started.is_cpu else ""
    compiling = f"compiling (some {compiling_seconds(scene):g} s the first time, then cached)"
    return f"computing on {device} in {scene.precision}{why}; {compiling}"


def _save_scene(scene: Scene, folder: RunFolder) -> None:
    try:
        folder.claim(name for name in copies(scene, folder.path).values() if not (folder.path / name).exists())
        scene.save(folder.path)
    except OSError as error:
        raise RunError(f"{folder.path}: the scene cannot be written: {error.strerror or error}") from None
