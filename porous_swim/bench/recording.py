"""What recording, tables and statistics cost: the shipped crystal, CPU time beside that of its swimmers."""

from __future__ import annotations

import time
from collections.abc import Sequence

from porous_swim.bench.figure import Conditions, Figure, Setting
from porous_swim.core.stopwatch import Stopwatch
from porous_swim.results.run_folder import RunFolder
from porous_swim.running.observation import Observers
from porous_swim.running.simulation import Simulation
from porous_swim.scene.scene import load_scene
from porous_swim.scene.shipped import scenes_folder

MOST = 0.1


def figures(setting: Setting) -> Sequence[Figure]:
    """Times of what a run does besides swimming, over the whole of it or over swimming."""
    scene = load_scene(scenes_folder() / "crystal.yaml")
    scene = scene.replace(
        {"run.device": "cpu", "run.threads": 1,
         "run.duration": setting.counts.frames * scene.record_period * scene.run.time_step}
    )  # fmt: skip
    simulation, watch = Simulation(scene), Stopwatch(time.process_time)
    folder = RunFolder.at(setting.folder / "recording", overwrite=True)
    with watch.timing("recording"):
        observers = Observers(simulation, folder, watch, progress=False, recording=True)
    observers.observe()
    while simulation.step < scene.n_steps:
        with watch.timing("swimming"):
            simulation.advance(scene.record_period)
        observers.observe()
    observers.results(rate=None)
    n = scene.swimmers.count
    steps = n * scene.n_steps
    where = Conditions(scene.precision, 1, n, len(simulation.field.radii), scene.n_steps, 2)
    parts = {name: seconds / steps * 1e9 for name, seconds in watch.seconds.items()}
    share = watch.seconds["recording"] / sum(watch.seconds.values())
    besides = (watch.seconds["recording"] + watch.seconds["statistics"]) / watch.seconds["swimming"]
    return [
        Figure("recording and encounters of crystal.yaml over its run", share, where, target=MOST, nanoseconds=parts),
        Figure("recording and statistics of crystal.yaml over swimming", besides, where),
    ]
