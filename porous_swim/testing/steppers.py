"""What every stepper must do: swimmers in the plane around one colloid, some of which touch it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from porous_swim.core.errors import SceneError
from porous_swim.engine.snapshot import Snapshot
from porous_swim.running.simulation import Simulation
from porous_swim.scene.scene import Scene

_RADIUS, _COUNT, _STEPS, _TIME_STEP = 3.0, 48, 300, 0.02
_FIELDS = ("position", "director", "colloid", "image", "bound", "start")


def check_stepper(integrator: str) -> None:
    """Require of the stepper that `run.integrator` names, in each precision that it takes:

    one lane and full ones, and launches however they are cut, move swimmers to the same bits; directors stay unit
    vectors, no swimmer reaches into the colloid, and encounters are found; without flow and noise a swimmer that meets
    nothing goes straight at speed 1; without noise a mirrored start leads to the mirrored end; scenes for which it is
    not made are refused at `run.integrator`.
    """
    taken = 0
    for precision in ("f32", "f64"):
        for noise in (0.0, 0.01, None):
            try:
                _scene(integrator=integrator, precision=precision, noise=noise)
            except SceneError as error:
                message = str(error)
                assert "run.integrator" in message, f"{integrator}: expected an error at run.integrator: {message}"
                continue
            taken += 1
            scene = {"integrator": integrator, "precision": precision, "noise": noise}
            if noise:
                check_lanes(**scene)
            else:
                _check_straight(scene)
                _check_mirror(scene)
                if noise is None:
                    check_lanes(**scene)
    assert taken, f"{integrator}: no scene takes it"


def check_lanes(**scene: Any) -> None:
    """Require that one lane and full lanes, and however launches are cut, give the same bits, and sound swimmers."""
    of = _scene(**scene)
    one, full = Simulation(of, lanes=1), Simulation(of)
    one.advance(_STEPS)
    for part in (_STEPS // 3, 1, _STEPS - _STEPS // 3 - 1):
        full.advance(part)
    first, second = one.engine.snapshot(), full.engine.snapshot()
    for name in _FIELDS:
        same = np.array_equal(getattr(first, name), getattr(second, name))
        assert same, f"{_words(of)}: {name} of one lane differs from that of full lanes, whose launches are cut"
    rows, others = one.engine.encounters(), full.engine.encounters()
    for name, column in rows.items():
        assert np.array_equal(column, others[name], equal_nan=column.dtype.kind == "f"), f"{_words(of)}: {name} differs"
    assert len(rows["swimmer"]), f"{_words(of)}: no encounter was found, where many swimmers meet the colloid"
    _check_sound(first, of)


def _check_sound(now: Snapshot, scene: Scene) -> None:
    length = np.linalg.norm(now.director, axis=1)
    assert np.abs(length - 1.0).max() < 1e-6, f"{_words(scene)}: a director is no unit vector"  # roundings of f32
    height = np.linalg.norm(now.position, axis=1) - _RADIUS
    # a sphere touches at height 1; in f32 offsets of 4 and their lengths round to 5e-7
    assert height.min() > 1.0 - 5e-6, f"{_words(scene)}: a swimmer is {1.0 - height.min():g} below contact"


def _check_straight(scene: Mapping[str, Any]) -> None:
    """Swim to where the colloid is not, within 100 roundings of a coordinate of 20: less than one a step."""
    of = _scene(**scene, strength=0.0, away=True)
    simulation = Simulation(of)
    start = simulation.engine.snapshot()
    simulation.advance(_STEPS)
    end = simulation.engine.snapshot()
    off = np.abs(end.position - start.position - _STEPS * _TIME_STEP * start.director).max()
    most = 100.0 * 20.0 * {"f32": 1.2e-7, "f64": 2.3e-16}[of.precision]
    assert off <= most, f"{_words(of)}: a free swimmer is {off:g} from where it goes straight at speed 1"
    assert np.array_equal(end.director, start.director), f"{_words(of)}: a free swimmer turns"


def _check_mirror(scene: Mapping[str, Any]) -> None:
    """The line of starts is its own mirror image in y: so are the ends, but for rounding that collisions enlarge."""
    simulation = Simulation(_scene(**scene))
    start = simulation.engine.snapshot().position
    simulation.advance(_STEPS // 3)
    position = simulation.engine.snapshot().position
    for swimmer, at in enumerate(start):
        twin = int(np.argmin(np.linalg.norm(start - at * [1.0, -1.0, 1.0], axis=1)))
        off = np.abs(position[twin] - position[swimmer] * [1.0, -1.0, 1.0]).max()
        apart = np.linalg.norm(start[twin] - at * [1.0, -1.0, 1.0])
        assert off <= 1e-4 + 100.0 * apart, f"{scene}: mirrored swimmers end {off:g} from the mirrored place"


def _scene(
    *, integrator: str, precision: str = "f32", noise: float | None = 0.01, strength: float = 0.5, away: bool = False,
    hydrodynamics: Mapping[str, Any] | None = None, motility: Mapping[str, Any] | None = None,
) -> Scene:  # fmt: skip
    """Swimmers that come in a beam from the left of a colloid, or go away from it; `noise` is D, None for none."""
    kind = {"kind": "none"} if noise is None else {"kind": "brownian", "translational_diffusion": noise}
    release = {"kind": "beam", "origin": [-5.5, 0.0], "director": [-1.0 if away else 1.0, 0.0], "width": 6.0}
    return Scene.from_mapping(
        {
            "swimmers": {
                "count": _COUNT, "dipole_strength": strength, "release": release,
                "motility": dict(motility or {"kind": "steady"}),
            },
            "hydrodynamics": dict(hydrodynamics or {"kind": "image_dipole"}),
            "noise": kind,
            "obstacles": {"layout": "single", "radius": _RADIUS},
            "domain": {"dimensions": 2},
            "run": {
                "time_step": _TIME_STEP, "duration": _STEPS * _TIME_STEP, "seed": 3, "device": "cpu", "threads": 1,
                "integrator": integrator, "precision": precision,
            },
            "record": {"every": _STEPS * _TIME_STEP},
        }
    )  # fmt: skip


def _words(scene: Scene) -> str:
    return f"{scene.integrator}, {scene.precision}, {scene.hydrodynamics.kind}, {scene.swimmers.motility.kind}"
