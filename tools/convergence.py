"""How far the answers of the schemes with noise depend on the step: `python tools/convergence.py [CASE ...]`.

Prints the rows of the tables of docs/convergence.md. The cases of trapping times are those of the figure TrappingTimes
of Spagnolie et al. (Soft Matter 11, 3396, 2015); swimmers start in contact with pitch 0. Times are of one thread.
"""

from __future__ import annotations

import argparse
import time

import porous_swim as ps
from porous_swim.paper.noise import Case, mean_of, trapping_times
from porous_swim.scene.shipped import scenes_folder

STEPS = {"reflected": (0.16, 0.08, 0.04, 0.02, 0.01, 0.005), "euler": (0.02, 0.01, 0.005)}
TRAPPING = {  # case and duration: the mean and eight or more standard deviations of T_h
    "trapping-a": (Case(20.0, 0.8, 0.002), 150.0),
    "trapping-b": (Case(20.0, 0.8, 0.004), 120.0),
    "trapping-c": (Case(20.0, 0.2, 0.002), 40.0),
    "trapping-d": (Case(320.0, 0.2, 0.002), 300.0),
}
CRYSTALS = {  # changes of scenes/crystal.yaml
    "crystal": {},
    "crystal-thermal": {"noise.translational_diffusion": 0.05},
    "crystal-weak": {"swimmers.dipole_strength": 2.0},
    "lattice": {
        "obstacles": {"layout": "fcc", "radius": 5.0, "spacing": 16.0, "cells": [6, 6, 6]},
        "domain": {"dimensions": 3}, "swimmers.dipole_strength": 0.8, "noise.translational_diffusion": 0.002,
    },
    "rods": {"swimmers.aspect_ratio": 0.5, "swimmers.dipole_strength": 0.3},
}  # fmt: skip
CRYSTAL_TIME = 300.0


def trapping(name: str, integrator: str, time_step: float, count: int) -> str:
    """Mean first passages of the escape pitch and of the escape height."""
    case, duration = TRAPPING[name]
    duration = round(duration / time_step) * time_step
    scene = ps.load_scene(scenes_folder() / "paper" / "trapping.yaml").replace(
        {
            "swimmers.count": count, "run.duration": duration, "run.time_step": time_step, "run.integrator": integrator,
            "record.every": duration,
        }
    )  # fmt: skip
    (times,) = trapping_times(scene, [case])
    return " | ".join("{:.3f}({:.3f})".format(*mean_of(passage)) for passage in (times.pitch, times.height))


def crystal(name: str, integrator: str, time_step: float, count: int) -> str:
    """Mean residence time, and what one unit of time in encounters brings in wall push and turns."""
    duration = round(CRYSTAL_TIME / time_step) * time_step
    scene = ps.load_scene(scenes_folder() / "crystal.yaml").replace(
        {
            "swimmers.count": count, "run.duration": duration, "run.time_step": time_step, "run.integrator": integrator,
            "run.threads": 1, "record": {"every": duration, "swimmers": 0, "trails": 0}, **CRYSTALS[name],
        }
    )  # fmt: skip
    table = ps.run(scene).encounters
    residence, turns = ps.analysis.residence_times(table), ps.analysis.winding(table).rate
    within = sum((table["end_time"].to_numpy() - table["start_time"].to_numpy()).tolist())
    push = sum(table["wall_push"].to_pylist()) / within
    return f"{residence.mean:.3f}({residence.standard_error:.3f}) | {push:.4f} | {turns.value:.5f}"


def main() -> None:
    """Print a row for each case, scheme and step."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("case", nargs="*", help=f"of {', '.join((*TRAPPING, *CRYSTALS))}; by default all")
    parser.add_argument("--count", type=int, default=20_000, help="swimmers")
    parser.add_argument("--integrator", choices=STEPS, help="by default both")
    parser.add_argument("--steps", type=float, nargs="+", help="steps; by default several for each scheme")
    options = parser.parse_args()
    for name in options.case or (*TRAPPING, *CRYSTALS):
        measure = trapping if name in TRAPPING else crystal
        for integrator in [options.integrator] if options.integrator else STEPS:
            for time_step in options.steps or STEPS[integrator]:
                begin = time.perf_counter()
                found = measure(name, integrator, time_step, options.count)
                took = time.perf_counter() - begin
                print(f"| {name} | {integrator} | {time_step:g} | {found} | {took:.0f} s |", flush=True)


if __name__ == "__main__":
    main()
