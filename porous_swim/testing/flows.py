"""What every flow must do."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from porous_swim.core.registry import parts_of
from porous_swim.engine.probe import drift
from porous_swim.physics.hydrodynamics import Flow
from porous_swim.testing.models import check_described
from porous_swim.testing.steppers import check_lanes

_N = 64  # swimmers at each size
_SIZES = ((0.5, 1.0), (3.0, 0.6), (20.0, 2.5), (20.0, 40.0), (np.inf, 1.5), (np.inf, 30.0))  # radius, height
# Relative to the bound of the flow: some 50 roundings, each made (A + h)/h times larger by the height's subtraction
_ROUNDINGS = {"f64": 50 * 2.3e-16, "f32": 50 * 1.2e-7}


@dataclass(frozen=True)
class _Kind:
    """A flow, and what is not required of it."""

    word: str
    flow: Flow
    mirrored: bool
    turns_alone: bool
    flows_alone: bool
    axis: np.ndarray | None


def check_flow(
    kind: str, *, keys: Mapping[str, Any] | None = None, mirrored: bool = True, turns_alone: bool = False,
    flows_alone: bool = False, axis: Sequence[float] | None = None,
) -> None:  # fmt: skip
    """Require of the flow that is registered as `kind`, near spheres and a plane wall, in both precisions:

    it is described; turned swimmers drift and turn as turned, mirrored ones as mirrored; the director's rate is across
    the director; flow and turning are odd in the dipole strength, without one there is no flow; the flow is at most
    3 |alpha|/(4 h^2) fast at heights h above 2 and is gone far away; single precision agrees with double; one lane and
    full ones move swimmers to the same bits.

    Args:
        kind: its word in a scene; see `ps.register`.
        keys: its other keys, as a scene file has them.
        mirrored: False for a flow that has a handedness.
        turns_alone: True where directors turn without a dipole, too.
        flows_alone: True where a flow has numbers of its own by which it flows without a dipole, too: what is said of
            strength and speed then holds for what the dipole adds, and `run.flight_step` is not for scenes with it.
        axis: of a flow around an axis of space (3,), such as that of a spin: it is turned about this axis alone.
    """
    flows = parts_of(Flow)
    assert kind in flows, f"{kind}: no flow is registered by this word; there are {', '.join(flows)}"
    check_described(flows[kind])
    given: dict[str, Any] = {Flow.TAG: kind, **(keys or {})}
    flow = flows[kind](**given)
    of_kind = _Kind(kind, flow, mirrored, turns_alone, flows_alone, None if axis is None else np.array(axis, float))
    for number, (radius, height) in enumerate(_SIZES):
        for precision in ("f64", "f32"):
            of = partial(drift, radius=radius, hydrodynamics=flow, precision=precision, aspect_ratio=0.4)
            _check_symmetries(of, of_kind, radius, height, number, precision)
            _check_strength(of, of_kind, radius, height, number, precision)
        _check_precisions(of_kind, radius, height, number)
    _check_far(of_kind)
    check_lanes(hydrodynamics=given, integrator="euler")


def _places(radius: float, height: float, number: int) -> tuple[np.ndarray, np.ndarray, np.random.Generator]:
    """Return offsets (n, 3) from the centre of a sphere or the foot on a wall, unit directors (n, 3), a generator."""
    rng = np.random.default_rng(number)
    normal, director = rng.normal(size=(2, _N, 3))
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    director /= np.linalg.norm(director, axis=1, keepdims=True)
    return (height if np.isinf(radius) else radius + height) * normal, director, rng


def _allowance(radius: float, height: float, precision: str) -> float:
    """Return how far two ways to compute a flow of strength 1 may be apart."""
    lost = 1.0 if np.isinf(radius) else (radius + height) / height
    return _ROUNDINGS[precision] * lost * (1.0 + 1.0 / height**3)


def _check_symmetries(of: Any, kind: _Kind, radius: float, height: float, number: int, precision: str) -> None:
    offset, director, rng = _places(radius, height, number)
    velocity, rate = of(offset, director, dipole_strength=1.0)
    where = f"{kind.word}, radius {radius:g}, height {height:g}, {precision}"
    least = _allowance(radius, height, precision)
    for array in (velocity, rate):
        assert array.shape == (_N, 3), f"{where}: expected the shape {(_N, 3)}, found {array.shape}"
        assert array.dtype == {"f64": np.float64, "f32": np.float32}[precision], f"{where}: found {array.dtype}"
        assert np.all(np.isfinite(array)), f"{where}: the drift is not finite"
    along = np.abs(np.sum(rate * director, axis=1)).max()
    assert along <= least, f"{where}: the director's rate is {along:g} along the director, where it is to be across"
    Q = _turn(kind.axis, rng)
    for turn in (Q, -Q) if kind.mirrored else (Q,):
        turned = of(offset @ turn.T, director @ turn.T, dipole_strength=1.0)
        for found, expected, what in zip(turned, (velocity, rate), ("velocity", "rate"), strict=True):
            off = np.abs(found - expected @ turn.T).max()
            way = "turned" if np.linalg.det(turn) > 0.0 else "mirrored"
            assert off <= least, f"{where}: the {what} of {way} swimmers is {off:g} from the {way} {what}"


def _turn(axis: np.ndarray | None, rng: np.random.Generator) -> np.ndarray:
    """Return a random rotation (3, 3), about `axis` where there is one: two mirrors whose normals are across it."""
    if axis is None:
        Q, _ = np.linalg.qr(rng.normal(size=(3, 3)))
        return np.asarray(Q * np.linalg.det(Q))
    normals = rng.normal(size=(2, 3))
    normals -= np.outer(normals @ axis, axis) / (axis @ axis)
    first, second = (np.eye(3) - 2.0 * np.outer(n, n) / (n @ n) for n in normals)
    return np.asarray(first @ second)


def _check_strength(of: Any, kind: _Kind, radius: float, height: float, number: int, precision: str) -> None:
    offset, director, _ = _places(radius, height, number)
    where = f"{kind.word}, radius {radius:g}, height {height:g}, {precision}"
    least = _allowance(radius, height, precision)
    (push, turn), (pull, back), (quiet, still) = (of(offset, director, dipole_strength=s) for s in (1.0, -1.0, 0.0))
    rounded = director.astype(quiet.dtype)
    alone = np.abs(quiet - rounded).max()
    assert kind.flows_alone or alone <= least, f"{where}: there is a flow without a dipole"
    assert kind.turns_alone or not np.any(still), f"{where}: directors turn without a dipole"
    for there, again, rest, what in ((push, pull, quiet, "flow"), (turn, back, still, "turning")):
        off = np.abs(there.astype(float) + again - 2.0 * rest).max()
        assert off <= least, f"{where}: the {what} is not odd in the dipole strength, by {off:g}"
    if height > 2.0:
        fastest = np.linalg.norm(push - (quiet if kind.flows_alone else rounded), axis=1).max()
        most = 0.75 / height**2 * (1.0 + 1e-3) + least
        assert fastest <= most, f"{where}: the flow is {fastest:g} fast, flights rely on at most 3 |alpha|/(4 h^2)"


def _check_precisions(kind: _Kind, radius: float, height: float, number: int) -> None:
    offset, director = (each.astype(np.float32) for each in _places(radius, height, number)[:2])
    law: dict[str, Any] = dict(radius=radius, dipole_strength=1.0, aspect_ratio=0.4, hydrodynamics=kind.flow)
    double, single = (drift(offset, director, **law, precision=precision) for precision in ("f64", "f32"))
    for fine, coarse, what in zip(double, single, ("velocity", "rate"), strict=True):
        off = np.abs(fine - coarse).max()
        least = _allowance(radius, height, "f32")
        where = f"{kind.word}, radius {radius:g}, height {height:g}"
        assert off <= least, f"{where}: the {what} is {off:g} off in single precision"


def _check_far(kind: _Kind) -> None:
    """At 1e5 half-lengths the fastest flow that is allowed is 7.5e-11 alpha; here a thousandth above rounding."""
    for radius in (5.0, np.inf):
        offset, director, _ = _places(radius, 1e5, 99)
        law: dict[str, Any] = dict(radius=radius, aspect_ratio=0.4, hydrodynamics=kind.flow)
        (velocity, rate), (quiet, still) = (drift(offset, director, dipole_strength=s, **law) for s in (1.0, 0.0))
        rest = quiet if kind.flows_alone else director
        fastest, turning = np.abs(velocity - rest).max(), np.abs(rate - still).max()
        assert max(fastest, turning) <= 7.6e-11, (
            f"{kind.word}: far from a colloid there is a drift of {fastest:g}, {turning:g}"
        )
