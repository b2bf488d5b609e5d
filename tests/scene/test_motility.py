"""What a scene says of how swimmers swim and turn by themselves."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from typing import Any, Literal

import pytest
import taichi as ti

import porous_swim as ps
from porous_swim.core.registry import forget

SECTIONS: dict[str, Any] = {"obstacles": {"layout": "single", "radius": 3.0}}
NOISE = {"kind": "brownian", "translational_diffusion": 0.01}


class Circling(ps.Motility):
    """It turns by the same angle in each step."""

    kind: Literal["circling"]

    @staticmethod
    @cache
    def make_reorient(model: Any) -> Any:
        real = model.real

        @ti.func
        def reorient(e, law, at):
            return e * real(-1.0)

        return reorient


@pytest.fixture
def circling() -> Iterator[None]:
    ps.register(Circling)
    yield
    forget(Circling)


def scene_of(motility: dict[str, Any] | None, noise: dict[str, Any] | None = None, **run: Any) -> ps.Scene:
    swimmers = {"count": 2, "dipole_strength": 0.5, "release": {"kind": "point", "position": [0, 0, 20]}}
    if motility is not None:
        swimmers["motility"] = motility
    run = {"time_step": 0.01, "duration": 1.0, **run}
    return ps.Scene.from_mapping({**SECTIONS, "swimmers": swimmers, "noise": noise or {"kind": "none"}, "run": run})


@pytest.mark.usefixtures("circling")
def test_steady_is_the_default_and_changes_no_scene_id() -> None:
    plain, steady, other = (scene_of(each) for each in (None, {"kind": "steady"}, {"kind": "circling"}))
    assert plain.scene_id == steady.scene_id == "4b93222bcd2448d2"
    assert other.scene_id != plain.scene_id
    assert "motility: {kind: circling}" in other.to_yaml()


@pytest.mark.usefixtures("circling")
def test_swimmers_that_turn_by_themselves_are_not_located() -> None:
    assert [scene_of({"kind": kind}).integrator for kind in ("steady", "circling")] == ["located", "euler"]
    assert scene_of({"kind": "circling"}, NOISE).integrator == "reflected"
    with pytest.raises(ps.SceneError, match=r"run\.integrator: located is for swimmers that do not turn by themselves"):
        scene_of({"kind": "circling"}, integrator="located")


@pytest.mark.usefixtures("circling")
def test_only_steady_swimmers_fly() -> None:
    assert scene_of({"kind": "steady"}, NOISE, flight_step=0.1).flight_ticks == 10
    with pytest.raises(ps.SceneError, match=r"run\.flight_step: flights are for the motility steady: found circling"):
        scene_of({"kind": "circling"}, NOISE, flight_step=0.1)
