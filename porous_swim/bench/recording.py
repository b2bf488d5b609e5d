"""What observers, tables and the recording cost: the shipped crystal, CPU time beside that of its swimmers."""

from __future__ import annotations

import time
from collections.abc import Sequence

from porous_swim.bench.figure import Conditions, Figure, Setting
from porous_swim.observation import Observers
from porous_swim.results import RunFolder
from porous_swim.scene import load_scene
from porous_swim.simulation import Simulation
from porous_swim.templates import scenes_folder

MOST = 0.1


def figures(setting: Setting) -> Sequence[Figure]:
    """Time of observers, from their making to the run folder, over the time of advancing."""
    scene = load_scene(scenes_folder() / "crystal.yaml")
    scene = scene.replace(
        {"run.device": "cpu", "run.threads": 1,
         "run.duration": setting.counts.frames * scene.record_period * scene.run.time_step}
    )  # fmt: skip
    simulation = Simulation(scene)
    clock, advancing = time.process_time, 0.0
    begin = clock()
    folder = RunFolder.at(setting.folder / "recording", overwrite=True)
    observers = Observers(simulation, folder, progress=False, recording=True)
    observers.observe()
    while simulation.step < scene.n_steps:
        last = clock()
        simulation.advance(scene.record_period)
        advancing += clock() - last
        observers.observe()
    observers.results(rate=None)
    observing = clock() - begin - advancing
    n = scene.swimmers.count
    steps = n * scene.n_steps
    where = Conditions(scene.precision, 1, n, len(simulation.field.radii), scene.n_steps, 2)
    parts = {"advancing": advancing / steps * 1e9, "recording": observing / steps * 1e9}
    name = "recording of crystal.yaml over advancing its swimmers"
    return [Figure(name, observing / advancing, where, target=MOST, nanoseconds=parts)]
