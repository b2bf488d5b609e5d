"""Single trajectories without noise in two crystals, against independently integrated ones.

Ten starts, in the open and in contact: approaches, orbits, lift-offs, passages from one colloid's neighbourhood to
the next, a slide along a mid-plane, and one that amplifies an initial error 7000 times.
"""

from __future__ import annotations

import csv

import numpy as np
import pytest

import porous_swim as ps
from tests.validation.agreement import reference
from tests.validation.scenes import LATTICES, make_scene

PATHS = reference("trajectories.json")
LATTICE_OF = {"hex_2d": "hexagonal_alpha4", "fcc_3d": "fcc_3d"}
STEPS = (4e-3, 2e-3, 1e-3, 5e-4)
# No event but touching a wall, which ends in a tangential motion: the error is then smooth in the step.
SMOOTH = {"void_east", "void_to_gap", "contact_inward"}
cases = pytest.mark.parametrize("case", LATTICE_OF)


def run_starts(case: str, time_step: float, folder, integrator: str) -> ps.Results:
    """The starts of one lattice, to t = 20."""
    starts = PATHS[case].values()
    with (folder / "starts.csv").open("w", newline="", encoding="utf-8") as file:
        csv.writer(file).writerows(
            [["x", "y", "z", "ex", "ey", "ez"], *([*start["position0"], *start["director0"]] for start in starts)]
        )
    lattice = LATTICES[LATTICE_OF[case]]
    scene = make_scene(
        swimmers={
            "count": len(starts), "dipole_strength": lattice["alpha"], "release": {"kind": "file", "path": "starts.csv"}
        },
        obstacles=lattice["obstacles"], dimensions=lattice["dimensions"], folder=folder,
        run={"time_step": time_step, "duration": 20.0, "precision": "f64", "integrator": integrator},
        record={"every": 5.0, "swimmers": len(starts)},
    )  # fmt: skip
    return ps.run(scene)


def states_at(case: str, time_step: float, folder) -> np.ndarray:
    """Position and director of each start at t = 5 and 20 with Euler's scheme, (2, n_starts, 6)."""
    return states_of(run_starts(case, time_step, folder, "euler"))


def states_of(results: ps.Results) -> np.ndarray:
    """The same of a run."""
    tracks = ps.analysis.tracks(results.trajectory)
    return np.concatenate([tracks.position, tracks.director], axis=2)[[1, 4]]


def listed_states(case: str):
    """Name, place in `states_at`, and the listed state, one by one."""
    for swimmer, (name, start) in enumerate(PATHS[case].items()):
        for time, state in enumerate(start["states"]):
            yield name, (time, swimmer), state


def largest_error(ours: np.ndarray, state) -> float:
    """The largest error of a component of position and director (6,)."""
    return float(np.max(np.abs(ours - np.array([*state["position"], *state["director"]]))))


@cases
def test_errors_at_a_step_of_5e5_are_those_of_another_program_with_the_same_scheme(case, tmp_path):
    """So are those of the extrapolates: each to as many decimals as the exact states are listed with."""
    fine, coarse = (states_at(case, time_step, tmp_path) for time_step in (5e-5, 1e-4))
    for name, place, state in listed_states(case):
        error = largest_error(fine[place], state)
        extrapolated = largest_error(2.0 * fine[place] - coarse[place], state)
        print(f"{name} at t = {state['t']:g}: error {error:.3g}, extrapolated {extrapolated:.3g}")
        # Either side of a difference may be off by a unit of the last trusted decimal.
        tolerance = 2.0 * 10.0 ** -state["decimals_trusted"]
        assert error == pytest.approx(state["euler_5e5_max_error"], abs=tolerance, rel=0), name
        assert extrapolated == pytest.approx(state["euler_richardson_max_error"], abs=tolerance, rel=0), name


@cases
def test_trajectories_converge_at_first_order_to_the_listed_ones(case, tmp_path):
    runs = np.stack([states_at(case, time_step, tmp_path) for time_step in STEPS])
    for name, place, state in listed_states(case):
        errors = [largest_error(run[place], state) for run in runs]
        order = np.polyfit(np.log(STEPS), np.log(errors), 1)[0]
        extrapolated = largest_error(2.0 * runs[-1][place] - runs[-2][place], state)
        print(f"{name} at t = {state['t']:g}: errors {errors}, order {order:.3f}, extrapolated {extrapolated:.3g}")
        if name in SMOOTH:
            # error = c dt + d dt^2: d dt/c is the extrapolate's share of the error, below 0.2 % at 2e-3; over a
            # factor of 8 in the step the order then is 1 within 0.005. The extrapolate's error falls as dt^2.
            assert order == pytest.approx(1.0, abs=0.005)
            assert extrapolated < 1.5 * state["euler_richardson_max_error"] * (STEPS[-1] / 5e-5) ** 2
        else:
            # The change of the nearest colloid, where the drift jumps, falls somewhere in a step: an error of first
            # order too, with a factor between 0 and 1 in place of a constant. It is at most half of the whole here
            # (`extrapolated` below), so that errors scatter by up to a factor of 1.5, and the order, with weights
            # 0.43, 0.14, -0.14, -0.43 over ln 2 times 1.49, by 0.25.
            assert order == pytest.approx(1.0, abs=0.25)
            assert extrapolated < 0.5 * state["euler_5e5_max_error"] * (STEPS[-1] / 5e-5)


@cases
@pytest.mark.parametrize("time_step", [0.1, 0.02])
def test_located_trajectories_are_the_listed_ones_to_every_decimal_whatever_the_step(case, time_step, tmp_path):
    results = run_starts(case, time_step, tmp_path, "located")
    ours = states_of(results)
    for name, place, state in listed_states(case):
        # one unit of the last trusted decimal: positions are listed to 7 to 11 of them
        assert largest_error(ours[place], state) < 10.0 ** -state["decimals_trusted"], name
    rows = results.encounters.to_pylist()
    for swimmer, (name, start) in enumerate(PATHS[case].items()):
        times = [(row["start_time"], row["end_time"]) for row in rows if row["swimmer"] == swimmer]
        listed = [(encounter["start"], encounter["end"]) for encounter in start["encounters"]]
        # events are located to rounding; the listed ones to 1e-10
        assert np.array(times) == pytest.approx(np.array(listed), rel=0, abs=1e-9), name
