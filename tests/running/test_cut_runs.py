"""A run that is cut is the same run: what it leaves does not tell that a new object took over in the middle."""

from __future__ import annotations

import numpy as np
import pytest

import porous_swim as ps
from porous_swim.core.errors import RunError
from porous_swim.core.state import State, restore_parts, state_of
from porous_swim.core.stopwatch import Stopwatch
from porous_swim.results.run_folder import RunFolder
from porous_swim.running.guests import introduce
from porous_swim.running.observation import Observers
from tests.support.fingerprints import (
    CRYSTAL,
    FCC,
    PACKING,
    PLANE,
    QUIET,
    RODS,
    THERMAL,
    differences,
    prints_of,
    scene_of,
)

SCENES = {
    "spheres": scene_of(CRYSTAL, THERMAL, domain=PLANE, swimmers={"dipole_strength": 2.0}),
    "rods": scene_of(PACKING, THERMAL, swimmers=RODS),
    "located": scene_of(CRYSTAL, QUIET, domain=PLANE, swimmers={"count": 24, "dipole_strength": 0.3}),
    "flights": scene_of({**FCC, "spacing": 40.0}, THERMAL, run={"flight_step": 0.5, "duration": 80}),
}
CUT = 0.55  # of the run, in steps of a flight: between two frames


class Hops(ps.Observer):
    """A user's observer with a memory that is told of encounters."""

    wants_events = True

    def __init__(self) -> None:
        self.seen = np.zeros(0)

    def initialise(self, run: ps.RunView) -> None:
        self.schedule = ps.Every(40 * run.flight_ticks)

    def observe(self, frame: ps.Frame) -> None:
        events = (np.sort(each, axis=None) for each in (frame.winding, frame.residence, frame.hop_time, frame.hops))
        self.seen = np.concatenate([self.seen, [frame.time], *events])

    def state(self) -> dict[str, np.ndarray]:
        return {"seen": self.seen}

    def restore(self, state: State) -> None:
        self.seen = state["seen"]


class Run:
    """A run by hand, that may be cut."""

    def __init__(self, scene: ps.Scene, folder: RunFolder | None = None) -> None:
        self.simulation, self.hops = ps.Simulation(scene), Hops()
        introduce([self.hops], scene, self.simulation.field)
        self.observers = Observers(
            self.simulation, folder, Stopwatch(), progress=False, recording=folder is not None, guests=[self.hops]
        )

    def advance(self, end: int) -> Run:
        """Go on to step `end`, looking on the way, though not at the end."""
        while True:
            self.observers.observe()
            due = min(self.observers.next_step, end)
            if due == self.simulation.step:
                return self
            self.simulation.advance(due - self.simulation.step)
            if due == end and end < self.simulation.scene.n_steps:
                return self

    def state(self) -> dict[str, np.ndarray]:
        return state_of({"simulation": self.simulation, "observers": self.observers})

    def restore(self, state: State) -> None:
        restore_parts({"simulation": self.simulation, "observers": self.observers}, state)


def cut_of(scene: ps.Scene) -> int:
    ticks = scene.flight_ticks
    return int(CUT * scene.n_steps) // ticks * ticks + (ticks if ticks > 1 else 7)


@pytest.mark.parametrize("name", SCENES)
def test_a_run_that_is_cut_leaves_what_the_whole_run_leaves(name, tmp_path):
    scene = SCENES[name]
    whole = Run(scene).advance(scene.n_steps)
    expected = prints_of(whole.observers.results(rate=None))
    first = Run(scene).advance(cut_of(scene))
    assert 0 < first.simulation.step < scene.n_steps
    assert first.simulation.step % scene.record_period != 0
    np.savez(tmp_path / "state.npz", **first.state())
    first.advance(scene.n_steps)  # what goes on changes no state that was taken
    with np.load(tmp_path / "state.npz", allow_pickle=False) as stored:
        second = Run(scene)
        second.restore(dict(stored))
    assert second.simulation.step == cut_of(scene)
    found = prints_of(second.advance(scene.n_steps).observers.results(rate=None))
    assert differences(found, expected) == []
    assert np.array_equal(second.hops.seen, whole.hops.seen)
    assert differences(prints_of(first.observers.results(rate=None)), expected) == []  # nor does asking for one


def test_a_run_may_be_cut_before_its_first_step_and_twice(tmp_path):
    scene = SCENES["spheres"]
    expected = prints_of(Run(scene).advance(scene.n_steps).observers.results(rate=None))
    run = Run(scene)
    for end in (0, 700, 1100):
        state = run.advance(end).state() if end else run.state()
        run = Run(scene)
        run.restore(state)
    assert differences(prints_of(run.advance(scene.n_steps).observers.results(rate=None)), expected) == []


def test_a_state_of_another_run_is_refused(tmp_path):
    scene = SCENES["spheres"]
    state = ps.Simulation(scene).state()
    with pytest.raises(RunError, match=r"this state is of another scene: .* scene_id .*, found [0-9a-f]{16}"):
        ps.Simulation(scene.replace({"run.seed": 6})).restore(state)
    with pytest.raises(RunError, match=r"expected born of int64 \(16,\), found int64 \(8,\)"):  # windows
        ps.Simulation(scene.replace({"record.every": 0.1})).restore(state)
    with pytest.raises(RunError, match=r"expected last_start of float64 .*, found nothing"):
        ps.Simulation(scene).restore({k: array for k, array in state.items() if "/desk/" not in k})
    run = Run(scene)
    alone = Observers(run.simulation, None, Stopwatch(), progress=False, recording=False)
    with pytest.raises(RunError, match="this state is of a run with other observers: it lacks Hops"):
        run.observers.restore(alone.state())


def test_a_run_in_a_folder_goes_on_where_its_rows_are(tmp_path):
    scene = SCENES["spheres"]
    with RunFolder.at(tmp_path / "run") as folder:
        whole = Run(scene, folder).advance(scene.n_steps).observers.results(rate=None)
    with RunFolder.at(tmp_path / "cut") as folder:
        first = Run(scene, folder).advance(1111)
        state = first.state()
        first.advance(1500).observers.finish(interrupted=True)  # what it saw behind the state counts no more
        second = Run(scene, folder)
        second.restore(state)
        results = second.advance(scene.n_steps).observers.results(rate=None)
    # a file tells the id of its run, and a recording begins where it was taken up
    assert differences(prints_of(results), prints_of(whole)) == ["summary.files"]
    assert results.summary["files"].keys() == whole.summary["files"].keys()
    with RunFolder.at(tmp_path / "empty") as folder, pytest.raises(RunError, match=r"expected 192 rows .* found 0"):
        Run(scene, folder).restore(state)
