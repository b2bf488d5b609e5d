"""Scenes as typing errors, unit slips and hostile hands leave them: one mutated scene for each number.

    python -m tests.support.fuzz 24000 [first]

makes so many, loads and places each, and lists what ended in anything but a `SceneError`, or took longer than it may.
"""

from __future__ import annotations

import copy
import sys
import tempfile
import time
import traceback
from pathlib import Path
from typing import Any

import numpy as np
import yaml

import porous_swim as ps
from porous_swim.core.errors import SceneError

LONGEST = 20.0  # seconds of CPU for one scene: half of that takes a crowd of colloids far smaller than swimmers
MOST = 100_000  # colloids and swimmers that are placed: more of them take long by right

PLANE = {"dimensions": 2}
SEEDS: list[dict[str, Any]] = [
    {"obstacles": {"layout": "none"}, "domain": {"boundary": "open"},
     "release": {"kind": "point", "position": [0, 0, 0]}},
    {"obstacles": {"layout": "single", "radius": 20.0, "position": [0, 0]}, "domain": PLANE,
     "release": {"kind": "beam", "origin": [-40, 0], "director": [1, 0], "width": 5.0}},
    {"obstacles": {"layout": "single", "radius": 3.0}, "domain": {"boundary": "periodic", "size": [20, 20, 30]}},
    {"obstacles": {"layout": "wall", "normal": [0, 1]}, "domain": PLANE,
     "release": {"kind": "parallel", "height": 1.0, "colloid": 0}},
    {"obstacles": {"layout": "hexagonal", "radius": 3.5, "spacing": 10.0, "cells": [4, 3]}, "domain": PLANE},
    {"obstacles": {"layout": "square", "radius": 3.5, "spacing": 10.0, "cells": [4, 3]}, "domain": PLANE},
    {"obstacles": {"layout": "fcc", "radius": 3.5, "spacing": 10.0, "cells": [2, 2, 2]}},
    {"obstacles": {"layout": "random", "radius": [3.0, 1.0], "fractions": [0.5, 0.5], "count": 50,
                   "packing_fraction": 0.2, "min_gap": 0.1}, "domain": PLANE},
    {"obstacles": {"layout": "random", "radius": 2.0, "packing_fraction": 0.1}, "domain": {"size": [30, 30, 30]}},
    {"obstacles": {"layout": "packing", "radius": 2.0, "count": 40, "packing_fraction": 0.4}},
    {"obstacles": {"layout": "file", "path": "beads.csv"}, "domain": {"dimensions": 2, "size": [60, 60]}},
]  # fmt: skip
COMMON: dict[str, Any] = {
    "name": "fuzz",
    "description": "a scene to be changed",
    "units": {"length": "1 um", "speed": "5 um/s", "viscosity": "0.89 mPa s", "temperature": "300 K"},
    "swimmers": {"count": 20, "dipole_strength": 0.8, "aspect_ratio": 0.5},
    "hydrodynamics": {"kind": "image_dipole"},
    "noise": {"kind": "brownian", "translational_diffusion": 0.01, "rotational_diffusion": 0.005},
    "encounter": {"escape_height": 1.6, "contact_band": 0.05, "escape_pitch": "leading"},
    "run": {"time_step": 0.01, "duration": 2.0, "seed": 1, "precision": "auto", "integrator": "auto", "threads": 1},
    "record": {"every": 0.1, "swimmers": 5, "trails": 2},
}
VALUES: list[Any] = [
    0, -1, 1, 2, 3, 1e-300, 5e-324, 1e-30, 1e-12, 1e-6, 1e-3, 0.1, 0.5, 0.9999999, 1.0000001, 7, 12.5, 100, 1000, 1e4,
    1e5, 1e6, 1e7, 1e9, 1e12, 1e15, 1e30, 1e150, 1e200, 1e300, 1.7e308, -1e9, -1e300, 2**31, 2**53, 2**63, 2**64,
    10**40, 10**400, float("nan"), float("inf"), float("-inf"), None, True, False, "", "x", "auto", "1 um", "1e300 um",
    "5 km", "1e-300 s", "thermal", "exact", "1 um/um/um",
    "1 " + "k" * 5000, "\x1b[31m", "a" * 3000, [], [1], [0, 0], [1, 2, 3],
    [1, 2, 3, 4], [1e300, 1e300], [1e-300, 1.0], [[1]], {}, {"a": 1}, {"kind": "none"}, {"layout": "none"}, [1e9, 1],
    ["1 um", "2 um"], [3.0] * 500, "no/such/file.csv", "/", "a\x00b",
]  # fmt: skip
BEADS = [
    "x,y,radius\n10,10,3\n30,30,3\n50,50,4\n", "x,y,radius\n1e300,0,1\n", "x,y,radius\n1,1,1e-300\n5,5,1\n",
    "x,y,radius\n",
    "x,y,radius\n1,1,1\n1,1,1\n", "\x00\x01", "x,y\n1,2\n", "x,y,radius\n10,10,1e300\n", "x,y,radius\n10,10,nan\n",
    "x,y,radius\n" + "10,10,1\n" * 3000, "x,y,radius\n" + "".join(f"{i},{i % 7},1e-3\n" for i in range(3000)),
]  # fmt: skip


def mutated(rng: np.random.Generator) -> dict[str, Any]:
    """A scene with one to three changes."""
    seed = copy.deepcopy(SEEDS[int(rng.integers(len(SEEDS)))])
    scene = copy.deepcopy(COMMON) | {key: seed[key] for key in ("obstacles", "domain") if key in seed}
    if "release" in seed:
        scene["swimmers"]["release"] = seed["release"]
    for _ in range(int(rng.integers(1, 4))):
        _mutate(scene, rng)
    return scene


def _leaves(node: Any) -> list[tuple[Any, Any]]:
    """Every place of a value: what holds it, and its key there; numbers four times, as they can go wrong farthest."""
    keys = list(node) if isinstance(node, dict) else list(range(len(node)))
    found = []
    for key in keys:
        if isinstance(node[key], (dict, list)):
            found += _leaves(node[key])
        number = isinstance(node[key], (int, float)) and not isinstance(node[key], bool)
        found += [(node, key)] * (4 if number else 1)
    return found


def _mutate(scene: dict[str, Any], rng: np.random.Generator) -> None:
    places = _leaves(scene)
    node, key = places[int(rng.integers(len(places)))]
    way, value = rng.random(), node[key]
    if isinstance(value, (int, float)) and not isinstance(value, bool) and abs(value) < 1e200 and way < 0.7:
        scaled = value * 10.0 ** float(rng.integers(-3, 4) if way < 0.4 else rng.integers(-12, 13))
        node[key] = int(scaled) if isinstance(value, int) and np.isfinite(scaled) else scaled
    elif way < 0.75 and isinstance(node, dict):
        del node[key]
    elif way < 0.8 and isinstance(node, dict):
        node["".join(rng.permutation(list(str(key))))] = node.pop(key)
    else:
        node[key] = copy.deepcopy(VALUES[int(rng.integers(len(VALUES)))])


def text_of(scene: dict[str, Any], rng: np.random.Generator) -> bytes:
    """The scene as a file, now and then with bytes changed."""
    content = bytearray(yaml.safe_dump(scene, sort_keys=False, allow_unicode=True).encode("utf-8", "surrogatepass"))
    if rng.random() < 0.05:
        for _ in range(int(rng.integers(1, 4))):
            content[int(rng.integers(len(content)))] = int(rng.integers(256))
    return bytes(content)


def look(path: Path) -> str:
    """Load and place a scene; return what its error says, `large` where it is not placed for its size, or nothing."""
    try:
        scene = ps.load_scene(path)
        if scene.swimmers.count > MOST or _n_colloids(scene) > MOST:
            return "large"
        field = scene.place_obstacles()
        gamma = scene.swimmers.aspect_ratio
        scene.place_swimmers(field, lambda sine, radius: np.sqrt(sine**2 + gamma**2 * (1.0 - sine**2)))
        scene.warnings(field)
        assert scene.scene_id
    except SceneError as error:
        return str(error)
    return ""


def _n_colloids(scene: ps.Scene) -> float:
    """About how many colloids a layout places, from its numbers alone; those of a packing count ten times."""
    layout: Any = scene.obstacles
    if layout.layout == "packing":
        return 10.0 * layout.count if layout.count else MOST + 1.0
    if hasattr(layout, "cells"):
        return float(np.prod(np.array(layout.cells, float)) * len(layout.BASIS))
    if getattr(layout, "count", None):
        return float(layout.count)
    if getattr(layout, "packing_fraction", None) and scene.domain.size:
        return (
            layout.packing_fraction * float(np.prod(scene.domain.size)) / min(layout.radius) ** scene.domain.dimensions
        )
    return 0.0


def trial(folder: Path, number: int) -> tuple[str, str]:
    """Scene number so and so: its outcome, and what went wrong with it, or nothing."""
    rng = np.random.default_rng([number, 1])
    path = folder / "fuzz.yaml"
    (folder / "beads.csv").write_text(BEADS[int(rng.integers(len(BEADS)))], encoding="utf-8")
    path.write_bytes(text_of(mutated(rng), rng))
    begin = time.process_time()
    try:
        outcome = look(path)
    except Exception:
        return path.read_text(errors="replace"), traceback.format_exc()
    control = [letter for letter in outcome if ord(letter) < 32 and letter != "\n"]
    if control:
        return path.read_text(errors="replace"), f"control characters in {outcome!r}"
    seconds = time.process_time() - begin
    return outcome, f"took {seconds:.0f} s: {path.read_text(errors='replace')}" if seconds > LONGEST else ""


def main() -> None:
    count, first = (int(argument) for argument in (*sys.argv[1:], "0")[:2])
    found, outcomes = [], {"runs": 0, "large": 0, "refused": 0}
    with tempfile.TemporaryDirectory() as scratch:
        for number in range(first, first + count):
            if number % 1000 == 0:
                print(f"{number} ...", flush=True)
            outcome, wrong = trial(Path(scratch), number)
            outcomes[{"": "runs", "large": "large"}.get(outcome, "refused")] += 1
            if wrong:
                found.append(number)
                print(f"--- {number}: {outcome[:3000]}\n{wrong[-3000:]}", flush=True)
    print(f"{count} scenes: {outcomes}; {len(found)} ended in no error of ours or took too long: {found}")
    sys.exit(1 if found else 0)


if __name__ == "__main__":
    main()
