"""The benchmark: its reference in C does the engine's job, and the command runs. No speed is asserted."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import porous_swim as ps
from porous_swim.bench import report
from porous_swim.bench.figure import Conditions, Figure
from porous_swim.bench.job import TIME_STEP, OneColloid
from porous_swim.bench.reference import Build, Reference, compilers
from porous_swim.bench.timing import Ratio, take_turns
from porous_swim.bench.works import Bare
from tests.support.commands import porous_swim
from tests.support.engines import field_of, make_engine
from tests.validation.agreement import mean, require_agreement
from tests.validation.test_trapping import LISTED

CASES = json.loads((Path(__file__).parents[1] / "reference" / "hydrodynamics.json").read_text())["cases"]
FIGURE_KEYS = {
    "name", "value", "conditions", "target", "at_least", "unit", "quartiles", "nanoseconds", "verdict",
}  # fmt: skip
CONDITIONS = {"precision", "threads", "n_swimmers", "n_colloids", "n_steps", "dimensions", "rounds"}


@pytest.fixture(scope="module", params=sorted(compilers()) or ["none"])
def double(request, tmp_path_factory) -> Reference:
    """The reference in double precision, in blocks of 8."""
    made = None
    if request.param != "none":
        made = Build(request.param, 8, "f64").compile(tmp_path_factory.mktemp("c"))
    if made is None:
        pytest.skip("no C compiler that works")
    return made


@pytest.mark.parametrize("case", CASES)
def test_the_drift_in_c_is_that_of_the_oracle_and_of_the_engine(double, case):
    sine, cosine = np.sin(case["theta"]), np.cos(case["theta"])
    offset, director = np.array([[0.0, 0.0, case["A"] + case["h"]]]), np.array([[cosine, 0.0, sine]])
    numbers = dict(radius=case["A"], dipole_strength=case["alpha"])
    flow, rate = double.drift(offset, director, bretherton=case["Gamma"], **numbers)
    size = np.hypot(case["u_r"], case["u_perp"])
    # 1e-12: rounding of rho - A^2 for h << A, as of the engine in test_drift
    assert np.linalg.norm(flow[0] - [case["u_perp"], 0.0, case["u_r"]]) <= 1e-12 * size
    turning = case["Omega"] * np.array([-sine, 0.0, cosine])
    assert np.linalg.norm(rate[0] - turning) <= 1e-12 * max(abs(case["Omega"]), 0.01 * size)
    if 0.0 <= case["Gamma"] < 1.0:
        gamma = np.sqrt((1.0 - case["Gamma"]) / (1.0 + case["Gamma"]))
        velocity, engine_rate = ps.drift(offset, director, aspect_ratio=gamma, **numbers)
        assert np.linalg.norm(velocity[0] - director[0] - flow[0]) <= 2e-12 * size
        assert np.linalg.norm(engine_rate[0] - rate[0]) <= 2e-12 * max(abs(case["Omega"]), 0.01 * size)


def test_c_the_bare_kernel_and_the_engine_follow_the_same_noisy_paths(double):
    job, n, n_steps = OneColloid(), 128, 600
    state = job.start(n, "f64")
    engine = make_engine(
        field_of([[0, 0, 0]], job.radius), state[:3].T, state[3:].T, alpha=job.dipole_strength, D=job.diffusion,
        time_step=TIME_STEP, seed=job.seed, precision="f64", variates="uniform", threads=1,
    )  # fmt: skip
    engine.advance(n_steps)
    captures, *_ = engine.counts()
    bare = Bare(n, "f64", 8)
    bare.advance(n_steps)
    double.advance(state, slice(0, 64), first=0, n_steps=n_steps, job=job)  # in parts, as by two threads
    double.advance(state, slice(64, 128), first=0, n_steps=n_steps, job=job)
    assert captures > 5  # contact is part of the job
    now = engine.snapshot()
    expected = np.concatenate([now.position, now.director], axis=1).T
    assert np.abs(bare.state - expected).max() < 1e-11  # rounding
    # variates are in single precision, where C under -ffast-math may round otherwise: 600 kicks of 0.0045 (1 + 2^-23)
    assert np.abs(state - expected).max() < 1e-6


def test_c_and_the_engine_pass_the_escape_pitch_at_the_same_steps(double):
    job, n, n_steps = OneColloid(dipole_strength=0.2, time_step=0.02), 300, 1000
    sine = np.sin(0.375 * job.dipole_strength)
    engine = make_engine(
        field_of([[0, 0, 0]], job.radius), np.tile([0.0, 0.0, job.radius + 1.0], (n, 1)), np.tile([1.0, 0, 0], (n, 1)),
        alpha=job.dipole_strength, D=job.diffusion, time_step=job.time_step, seed=job.seed, precision="f64",
        variates="uniform", threads=1, escape_sine=sine,
    )  # fmt: skip
    engine.advance(n_steps)
    rows, times = engine.encounters(), np.full(n, np.inf)
    np.fmin.at(times, rows["swimmer"], rows["escape_pitch_time"])
    # 10^5 ends of steps, each within the paths' difference of 1e-6 of the escape pitch by a chance of 1e-5 or less
    n_other = np.count_nonzero(double.passages(n, sine=sine, job=job) != np.round(times / job.time_step))
    assert n_other <= 3
    later = double.passages(n - 100, sine=sine, job=job, begin=100)
    assert np.array_equal(later, double.passages(n, sine=sine, job=job)[100:])  # whoever had the lane before


@pytest.mark.parametrize("at", LISTED)
def test_the_paper_in_c_has_the_first_passages_of_an_independent_simulator(double, at):
    A, alpha, D = at
    job = OneColloid(A, alpha, D, time_step=0.001)
    found = mean(double.passages(4000, sine=np.sin(0.375 * alpha), job=job) * job.time_step)
    require_agreement({"T_theta": found}, {"T_theta": LISTED[at][0]})


def test_contenders_take_turns_and_the_first_round_does_not_count():
    now, calls = [0.0], []

    def work(name: str, seconds: float):
        def run() -> int:
            calls.append(name)
            now[0] += seconds
            return 10

        return run

    times = take_turns({"a": work("a", 2.0), "b": work("b", 4.0)}, 3, clock=lambda: now[0])
    assert calls == ["a", "b"] * 4
    assert times["a"].tolist() == pytest.approx([2e8] * 3)
    ratio = Ratio.of(times["a"] / times["b"])
    assert (ratio.low, ratio.median, ratio.high) == pytest.approx((0.5, 0.5, 0.5))


def test_the_command_prints_json_with_every_figure_and_what_it_was_measured_with(tmp_path):
    result = porous_swim("bench", "one_colloid", "--quick", "--json", cwd=tmp_path)
    assert result.returncode == 0, result.stderr
    found = json.loads(result.stdout)
    assert {"processor", "n_cpus", "taichi", "compilers", "load_before"} <= set(found["machine"])
    figures = found["figures"]["one_colloid"]
    assert len(figures) >= 2
    for figure in figures:
        assert set(figure) == FIGURE_KEYS
        assert set(figure["conditions"]) == CONDITIONS
        assert figure["value"] > 0.0
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("quick", [True, False])
def test_tiny_counts_give_no_verdicts(quick, monkeypatch):
    where = Conditions("f32", 1, 64, 1, 8)
    figures = [Figure("fast", 0.5, where, target=1.0), Figure("slow", 2.0, where, target=1.0)]
    monkeypatch.setitem(report.GROUPS, "lanes", lambda _: figures)
    found = report.benchmark(["lanes"], quick=quick)
    verdicts = [figure["verdict"] for figure in found["figures"]["lanes"]]
    last = report.text(found).splitlines()[-1]
    if quick:
        assert verdicts == ["", ""]
        assert last == "tiny counts: nothing here is a speed"
    else:
        assert verdicts == ["met", "missed"]
        assert last == "1 targets met, 1 missed"


def test_without_a_compiler_one_line_says_so(tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))
    result = porous_swim("bench", "fields", "--quick", cwd=tmp_path)
    assert result.returncode == 0, result.stderr
    assert [line for line in result.stderr.splitlines() if "compiler" in line] == [
        "bench: no C compiler (clang or gcc) that works was found: ratios to C are left out"
    ]
    assert "over blocked C" not in result.stdout


def test_an_unknown_group_is_named_with_its_near_miss(tmp_path):
    result = porous_swim("bench", "thread", cwd=tmp_path)
    assert (result.returncode, result.stdout) == (2, "")
    assert "bench thread: there is no such group (did you mean threads?)" in result.stderr


@pytest.mark.slow
def test_every_group_of_the_benchmark_runs(tmp_path):
    result = porous_swim("bench", "--quick", "--json", cwd=tmp_path)
    assert result.returncode == 0, result.stderr
    assert set(json.loads(result.stdout)["figures"]) == set(report.GROUPS)
