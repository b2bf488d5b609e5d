"""Every way to put the parts of the kernel together that a scene admits, few that cover all pairs, and a short run.

As a program it reads a list of combinations from stdin and runs one after the other: a kernel that LLVM cannot compile
ends the process, and then the last name that was printed says which.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterable, Sequence
from itertools import combinations, product

import numpy as np

import porous_swim as ps
from porous_swim.engine.probe import height_at_sine

Combination = dict[str, str]

CHOICES: dict[str, tuple[str, ...]] = {
    "hydrodynamics": ("none", "image_dipole", "near_wall"),
    "integrator": ("euler", "reflected", "located"),
    "noise": ("none", "gaussian", "uniform"),
    "shape": ("sphere", "rod", "needle"),
    "surface": ("spheres", "wall", "none"),
    "dimensions": ("2-D", "3-D"),
    "precision": ("f32", "f64"),
    "flights": ("steps", "flights"),
}
ASPECT_RATIO = {"sphere": 1.0, "rod": 0.5, "needle": 0.05}
N_STEPS, TIME_STEP, COUNT = 10, 0.02, 1000  # so many that some touch, also needles in space
RADIUS, SPACING = 3.0, 8.2  # a swimmer fits between two colloids, and is never far from one
D = 0.01
FLOW = 0.3  # U, of the reflected flow at contact: 3 alpha/(4 h^2) at its fastest, h = gamma at its least
KICK = 5.5 * np.sqrt(2.0 * D * TIME_STEP)  # the longest along an axis: the tails of the variates end there
# of a contact: a swimmer may reach into a colloid by 1e-6, and in f32 offsets of 6 and their lengths round to 1e-6
BELOW_CONTACT = 5e-6


def name_of(combination: Combination) -> str:
    """All choices, in the order of `CHOICES`."""
    return " ".join(combination[axis] for axis in CHOICES)


def scene_of(combination: Combination) -> ps.Scene:
    """A scene of ten steps; SceneError where it is not admitted."""
    gamma = ASPECT_RATIO[combination["shape"]]
    d = int(combination["dimensions"][0])
    noise: dict[str, object] = {"kind": "none"}
    if combination["noise"] != "none":
        noise = {"kind": "brownian", "translational_diffusion": D, "variates": combination["noise"]}
    layout = {"layout": "square" if d == 2 else "sc", "radius": RADIUS, "spacing": SPACING, "cells": [2] * d}
    spheres = {"obstacles": layout, "release": {"kind": "uniform"}}
    wall = {
        "obstacles": {"layout": "wall", "normal": [0.0] * (d - 1) + [1.0]},
        "release": {"kind": "point", "position": [0.0] * (d - 1) + [1.02]},
    }
    none = {"obstacles": {"layout": "none"}, "release": {"kind": "point", "position": [0.0] * d}}
    place = {"spheres": spheres, "wall": wall, "none": none}[combination["surface"]]
    run = {
        "time_step": TIME_STEP, "duration": N_STEPS * TIME_STEP, "seed": 1, "threads": 1, "device": "cpu",
        "integrator": combination["integrator"], "precision": combination["precision"],
    }  # fmt: skip
    if combination["flights"] == "flights":
        run["flight_step"] = 5 * TIME_STEP
    swimmers = {
        "count": COUNT, "dipole_strength": FLOW / 0.75 * gamma**2, "aspect_ratio": gamma, "release": place["release"],
    }  # fmt: skip
    return ps.Scene.from_mapping(
        {
            "name": "combination", "swimmers": swimmers, "hydrodynamics": {"kind": combination["hydrodynamics"]},
            "noise": noise, "obstacles": place["obstacles"], "domain": {"dimensions": d}, "run": run,
            "record": {"every": N_STEPS * TIME_STEP, "swimmers": COUNT},
        }
    )  # fmt: skip


def is_admitted(combination: Combination) -> bool:
    """Whether the reference allows it."""
    noisy, integrator = combination["noise"] != "none", combination["integrator"]
    if integrator == "located":
        return not noisy and combination["precision"] == "f64" and combination["flights"] == "steps"
    return noisy if integrator == "reflected" else combination["flights"] == "steps"


def everything() -> list[Combination]:
    """Every choice with every other."""
    return [dict(zip(CHOICES, choice, strict=True)) for choice in product(*CHOICES.values())]


def admitted() -> list[Combination]:
    """All that the reference allows."""
    return [combination for combination in everything() if is_admitted(combination)]


def pairs_of(combination: Combination) -> set[tuple[tuple[str, str], tuple[str, str]]]:
    """The pairs of choices that a combination brings together."""
    return set(combinations(combination.items(), 2))


def cover(candidates: Sequence[Combination]) -> list[Combination]:
    """Few of the candidates that hold every pair that any of them holds: always the next with most new pairs."""
    pairs = {name_of(combination): pairs_of(combination) for combination in candidates}
    missing, chosen = set().union(*pairs.values()), []
    while missing:
        best = max(candidates, key=lambda combination: len(pairs[name_of(combination)] & missing))
        missing -= pairs[name_of(best)]
        chosen.append(best)
    return chosen


def complaint(combination: Combination) -> str:
    """What is wrong after ten steps; empty where nothing is."""
    scene = scene_of(combination)
    results = ps.run(scene)
    table = results.trajectory
    table = results.trajectory
    columns = {name: table[name].to_numpy() for name in table.column_names}
    position, director = (np.stack([columns[p + axis] for axis in "xyz"], axis=1) for p in ("", "e"))
    image = np.stack([columns[f"image_{axis}"] for axis in "xyz"], axis=1)
    start, end = position[:COUNT], position[COUNT:]
    if len(end) != COUNT or not np.all(np.isfinite(position)):
        return "a position is missing or not finite"
    if np.abs(np.linalg.norm(director, axis=1) - 1.0).max() > 1e-6:  # single precision, some roundings
        return "a director is no unit vector"
    far = N_STEPS * ((1.0 + FLOW) * TIME_STEP + (combination["noise"] != "none") * KICK * np.sqrt(3.0))
    way = np.linalg.norm(end - start, axis=1)
    if way.max() > far or way.max() == 0.0:
        return f"swimmers moved by up to {way.max():g}: expected more than 0, at most {far:g}"
    if combination["surface"] == "none":
        return ""
    field = scene.place_obstacles()
    offset = position - field.centers[columns["colloid"]] - image * field.box
    height, sine = field.stance(offset, director, columns["colloid"])
    least = height_at_sine(sine, field.radii[columns["colloid"]], aspect_ratio=scene.swimmers.aspect_ratio)
    if (height - least).min() < -BELOW_CONTACT:
        return f"a swimmer is {(least - height).max():g} below contact"
    return "" if results.encounters.num_rows else "nobody touched a surface"


def run_all(wanted: Iterable[Combination]) -> None:
    """Print the name of each combination before its run, and behind it what is wrong with it."""
    for combination in wanted:
        print(json.dumps({"begins": name_of(combination)}), flush=True)
        try:
            wrong = complaint(combination)
        except ps.PorousSwimError as error:
            wrong = str(error)
        print(json.dumps({"name": name_of(combination), "wrong": wrong}), flush=True)


if __name__ == "__main__":
    run_all(json.load(sys.stdin))
