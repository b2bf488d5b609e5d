"""One run: a scene goes in, a run folder and `Results` come out."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from pathlib import Path

from porous_swim.core.console import tell
from porous_swim.core.errors import RunError
from porous_swim.core.stopwatch import Stopwatch
from porous_swim.engine.backend import Backend
from porous_swim.observers.base import Observer
from porous_swim.results.encounter_table import ROWS
from porous_swim.results.results import Results
from porous_swim.results.run_folder import RunFolder
from porous_swim.running.costs import compiling_seconds
from porous_swim.running.footprint import require_memory
from porous_swim.running.guests import introduce, observers_of
from porous_swim.running.interrupts import Interrupts
from porous_swim.running.observation import Observers
from porous_swim.running.simulation import Simulation, Start
from porous_swim.scene.identity import copies
from porous_swim.scene.scene import Scene

LOOK_SECONDS = 0.5  # between looks at the keyboard and at the clock; decides no result


def run(
    scene: Scene, *, out: Path | str | None = None, overwrite: bool = False, progress: bool = False,
    recording: bool = True, force_memory: bool = False, observers: Sequence[Observer] = (),
) -> Results:  # fmt: skip
    """Run a scene to its end and return its results.

    Args:
        scene: what to run.
        out: the run folder; None keeps everything in memory, without a recording.
        overwrite: allow `out` to hold an earlier run, whose files are replaced; no other file is touched.
        progress: say on stderr how far the run is.
        recording: write `recording.rrd`.
        force_memory: start even where the run is expected to need more memory than there is.
        observers: objects of your own subclasses of `Observer`, which look at the run at their own schedules.

    Raises:
        SceneError: colloids overlap, swimmers do not fit, or the run does not fit into memory.
        DeviceError: the device of the scene is not here.
        ResultsError: `out` is not empty, another run is under way in it, or it cannot be written.
        RunError: a swimmer could not go on, a file could not be written, or one of `observers` failed; `out` keeps
            what was seen, as far as it can, and its summary says what is missing.

    An interrupt (Ctrl-C, SIGTERM, SIGHUP) ends the run at the next look; the results say `interrupted`.
    """
    say = (lambda line: tell(line, sys.stderr)) if progress else None
    return run_in(
        lambda: (
            None if out is None else RunFolder.at(out, overwrite=overwrite, inputs=scene.inputs, say=say)
        ),
        scene=scene, progress=progress, recording=recording, force_memory=force_memory, guests=observers,
    )  # fmt: skip


def run_in(
    make_folder: Callable[[], RunFolder | None], *, scene: Scene, progress: bool, recording: bool = True,
    force_memory: bool = False, guests: Sequence[Observer] = (),
) -> Results:  # fmt: skip
    """The same in a folder that is made only when the scene is known to start, so that a mistake costs no old run."""
    watch = Stopwatch()
    with Interrupts() as interrupts, ExitStack() as stack:
        if not force_memory:
            require_memory(scene)
        with watch.timing("placing"):
            start = Start.of(scene)
        guests = (*observers_of(scene), *guests)
        introduce(guests, scene, start.field)
        folder = make_folder()
        if folder is not None:
            stack.enter_context(folder)
            _save_scene(scene, folder)
        if progress:
            tell(_device_line(scene, start.backend), sys.stderr)
        with interrupts.while_compiling(), watch.timing("compiling"):
            recording = recording and folder is not None
            log_path = None if folder is None else folder.path / ROWS
            events = recording or any(guest.wants_events for guest in guests)
            simulation = Simulation(scene, start, events=events, log_path=log_path)
        stack.callback(simulation.engine.close)
        observers = Observers(simulation, folder, watch, progress=progress, recording=recording, guests=guests)
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
    end = simulation.scene.n_steps
    watch.seconds["swimming"] = 0.0  # told before what the first look takes
    observers.observe()
    observers.clock.start(step=0)
    begin, at_once = time.perf_counter(), simulation.scene.flight_ticks
    while simulation.step < end and not interrupts:
        due = min(observers.next_step, end)
        last = time.perf_counter()
        with watch.timing("swimming"):
            simulation.advance(min(at_once, due - simulation.step))
        at_once = _next_launch(at_once, time.perf_counter() - last, unit=simulation.scene.flight_ticks)
        if simulation.step == due:
            observers.observe()
        observers.keep()
    observers.observe(last=True)  # an interrupt may come between two frames
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
