"""Observers of a user: what they see, when, and that they change nothing."""

from __future__ import annotations

import doctest
from pathlib import Path

import numpy as np
import pytest

import porous_swim as ps
from porous_swim.observers import base
from tests.support.commands import small_scene
from tests.support.fingerprints import differences, prints_of

FLIGHTS = {"run.flight_step": 0.05, "run.time_step": 0.01}  # 5 steps


@pytest.fixture
def scene(tmp_path: Path) -> ps.Scene:
    return ps.load_scene(small_scene(tmp_path))


class Steps(ps.Observer):
    """Notes what it is called with."""

    def __init__(self, schedule: base.Schedule | None = None) -> None:
        self.schedule = schedule
        self.frames: list[ps.Frame] = []
        self.finished: list[bool] = []

    def observe(self, frame: ps.Frame) -> None:
        self.frames.append(frame)

    def finish(self, *, interrupted: bool) -> None:
        self.finished.append(interrupted)

    @property
    def steps(self) -> list[int]:
        return [frame.step for frame in self.frames]


class Telling(Steps):
    """Wants to be told of events."""

    wants_events = True


class Failing(Steps):
    """Divides by zero at a step."""

    def observe(self, frame: ps.Frame) -> None:
        super().observe(frame)
        if frame.step >= 500:
            raise ZeroDivisionError("a mistake of the user")


def test_the_example_of_the_base_class_runs():
    found = doctest.DocTestFinder().find(base.Observer, "Observer", globs={})
    example = next(each for each in found if each.examples)
    assert doctest.DocTestRunner().run(example) == doctest.TestResults(failed=0, attempted=6)


def test_each_observer_looks_at_the_start_at_its_own_steps_and_at_the_end(scene):
    odd, even, record = Steps(ps.Every(7)), Steps(ps.Every(250)), Steps()
    ps.run(scene, observers=[odd, even, record])
    assert odd.steps == [*range(0, 1000, 7), 1000]
    assert even.steps == [0, 250, 500, 750, 1000]
    assert record.steps == list(range(0, 1001, 100))
    assert odd.finished == even.finished == record.finished == [False]


@pytest.mark.parametrize("changes", [{}, {"noise": {"kind": "none"}, "run.time_step": 0.01}], ids=["noise", "located"])
def test_an_observer_changes_no_bit_of_any_table(changes, scene):
    scene = scene.replace({"run.duration": 20.0, "record.every": 1.0, **changes})
    alone = prints_of(ps.run(scene))
    odd, telling = Steps(ps.Every(7)), Telling(ps.Every(11))
    odd.n_seen = 40
    assert differences(prints_of(ps.run(scene, observers=[odd, telling])), alone) == []


def test_an_observer_sees_what_the_trajectory_holds_of_as_many_swimmers_as_it_wants(scene):
    recorded, everyone, nobody = Steps(), Steps(), Steps()
    everyone.n_seen, nobody.n_seen = 40, 0
    results = ps.run(scene, observers=[recorded, everyone, nobody])
    x, state = (results.trajectory[name].to_numpy().reshape(11, 20) for name in ("x", "state"))
    for row, (frame, whole, empty) in enumerate(zip(recorded.frames, everyone.frames, nobody.frames, strict=True)):
        assert np.array_equal(frame.position[:, 0], x[row])
        assert np.array_equal(frame.state, state[row])
        assert np.array_equal(whole.position[:20], frame.position)
        assert (whole.position.shape, empty.position.shape) == ((40, 3), (0, 3))
        assert whole.ensemble == empty.ensemble


def test_each_observer_is_told_of_all_encounters_that_ended_since_it_looked(scene, tmp_path):
    scene = scene.replace({"run.duration": 40.0, "record.every": 1.0, "swimmers.dipole_strength": 2.0})
    often, seldom, deaf = Telling(ps.Every(130)), Telling(ps.Every(7000)), Steps(ps.Every(500))
    results = ps.run(scene, observers=[often, seldom, deaf], out=tmp_path / "run")
    rows = {name: results.encounters[name].to_numpy() for name in ("start_time", "end_time", "end_censored")}
    length = (rows["end_time"] - rows["start_time"])[~rows["end_censored"]]
    assert len(length) > 20
    for observer in (often, seldom):
        told = np.concatenate([frame.residence for frame in observer.frames])
        # the table computes times from the start; two roundings of 40 a/U
        np.testing.assert_allclose(np.sort(told), np.sort(length), atol=1e-13)
        assert sum(len(frame.hops) for frame in observer.frames) == observer.frames[-1].counts.n_hops > 0
    assert not any(frame.has_events or len(frame.residence) for frame in deaf.frames)


def test_what_an_observer_sees_cannot_be_changed(scene):
    class Meddling(ps.Observer):
        def observe(self, frame: ps.Frame) -> None:
            frame.position[:] = 0.0

    with pytest.raises(ps.RunError, match=r"observer .*Meddling failed at step 0 \(time 0\): ValueError: .*read-only"):
        ps.run(scene, observers=[Meddling()])


def test_an_observer_is_told_of_its_run(scene):
    class Curious(ps.Observer):
        def initialise(self, run: ps.RunView) -> None:
            self.run, self.schedule = run, ps.Every(round(0.3 / run.time_step))
            self.steps: list[int] = []

        def observe(self, frame: ps.Frame) -> None:
            self.steps.append(frame.step)

    curious = Curious()
    results = ps.run(scene, observers=[curious])
    run = curious.run
    assert (run.time_step, run.n_steps, run.record_period, run.flight_ticks) == (0.001, 1000, 100, 1)
    assert (run.n_swimmers, run.n_recorded) == (40, 20)
    assert run.scene == results.scene
    assert np.array_equal(run.field.centers[:, 0], results.colloids["x"].to_numpy())
    assert curious.steps == [0, 300, 600, 900, 1000]


def test_a_failing_observer_is_named_and_what_was_seen_is_kept(scene, tmp_path):
    failing, other = Failing(ps.Every(50)), Steps(ps.Every(125))
    whole = ps.run(scene)
    with pytest.raises(ps.RunError, match=r"observer Failing failed at step 500 \(time 0.5\): ZeroDivisionError: a mi"):
        ps.run(scene, observers=[failing, other], out=tmp_path / "run")
    kept = ps.load_results(tmp_path / "run", verify=True)
    assert kept.summary["status"] == "failed"
    assert "observer Failing failed at step 500" in kept.summary["warnings"][0]
    assert kept.timeseries.to_pydict() == whole.timeseries.slice(0, 6).to_pydict()
    assert failing.finished == other.finished == [True]


def test_results_are_whole_where_an_observer_fails_to_finish(scene, tmp_path):
    class Clumsy(ps.Observer):
        def finish(self, *, interrupted: bool) -> None:
            raise KeyError("plot")

    other = Steps()
    with pytest.raises(ps.RunError, match=r"Clumsy failed in finish: KeyError: 'plot'; the results .* are whole"):
        ps.run(scene, observers=[Clumsy(), other], out=tmp_path / "run")
    assert ps.load_results(tmp_path / "run", verify=True).summary["status"] == "finished"
    assert len(other.finished) == 1


def test_an_interrupted_run_is_seen_where_it_ended(scene, monkeypatch):
    advance = ps.Simulation.advance

    def interrupted_at_500(simulation: ps.Simulation, n_steps: int) -> None:
        advance(simulation, n_steps)
        if simulation.step >= 500:
            import os
            import signal

            os.kill(os.getpid(), signal.SIGTERM)

    monkeypatch.setattr(ps.Simulation, "advance", interrupted_at_500)
    steps = Steps(ps.Every(10_000))
    results = ps.run(scene, observers=[steps])
    assert results.summary["status"] == "interrupted"
    assert steps.frames[-1].time == results.info.last_time == results.timeseries["time"].to_numpy()[-1] < 1.0
    assert steps.finished == [True]


class Backward(ps.Observer):
    """Looks at steps that are over."""

    def due(self, step: int) -> int:
        return step


class Vague(ps.Observer):
    """Looks at no step."""

    def due(self, step: int) -> float:  # type: ignore[override]
        return step + 0.5


class Greedy(ps.Observer):
    """Wants more swimmers than there are."""

    n_seen = 41


@pytest.mark.parametrize(
    ("observer", "changes", "sentence"),
    [
        (Backward(), {}, r"observer Backward: due\(0\) returned 0: expected a step after 0"),
        (Vague(), {}, r"observer Vague failed in due: TypeError"),
        (Greedy(), {}, r"observer Greedy: n_seen: expected 0 to 40 swimmers, found 41"),
        (Steps(ps.Every(7)), FLIGHTS, r"due\(0\) returned 7, but with run.flight_step .* only every 5 steps"),
        (Steps, {}, r"observers: expected objects of .*porous_swim.Observer, found the class Steps itself: write"),
        (print, {}, r"observers: expected objects of .*porous_swim.Observer, found an object of type builtin"),
    ],
)  # fmt: skip
def test_an_observer_that_cannot_look_is_refused_before_it_costs_an_old_run(
    observer, changes, sentence, scene, tmp_path
):
    ps.run(scene, out=tmp_path / "run", recording=False)
    before = {path.name: path.stat().st_mtime_ns for path in (tmp_path / "run").iterdir()}
    with pytest.raises((ps.RunError, TypeError), match=sentence):
        ps.run(scene.replace(changes), observers=[observer], out=tmp_path / "run", overwrite=True)
    assert {path.name: path.stat().st_mtime_ns for path in (tmp_path / "run").iterdir()} == before


def test_flights_are_seen_at_their_multiples_and_no_bit_is_changed(scene):
    scene = scene.replace({**FLIGHTS, "run.duration": 5.0, "obstacles.spacing": 40.0})
    alone, steps = prints_of(ps.run(scene)), Steps(ps.Every(15))
    assert differences(prints_of(ps.run(scene, observers=[steps])), alone) == []
    assert steps.steps == [*range(0, 500, 15), 500]
