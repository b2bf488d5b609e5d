"""What the sections of a scene say against each other: all that a run would refuse before it places anything."""

from __future__ import annotations

from collections.abc import Callable

from porous_swim.core.parts import KeyedError, SeveralKeyedError
from porous_swim.core.scales import told
from porous_swim.engine.limits import LONGEST_LAUNCH
from porous_swim.physics.motility import Steady
from porous_swim.physics.noise import Brownian
from porous_swim.scene.model import SceneModel

_MOST_TURN = 0.017  # D_r times the length of a flight: kicks of 5.4 standard deviations then turn by one radian
_SPACING = {"f32": 2.0**-23, "f64": 2.0**-52}  # between a number near 1, such as a director's component, and the next
_WELL_ADDED = 100.0  # spacings of a turn that is rounded the same way again and again: then within 1 %
_WELL_KICKED = (
    10.0  # spacings of a random turn, which rounds to either side: it loses 1/12 of a percent of its variance
)


def disagreements(scene: SceneModel, *, whole: bool = True) -> list[KeyedError]:
    """Return what sections of `scene` say against each other; where it is not `whole`, as far as it has them."""
    found: list[KeyedError] = []
    for check in _CHECKS:
        try:
            check(scene)
        except SeveralKeyedError as several:
            found += several.errors
        except KeyedError as error:
            found.append(error)
        except AttributeError:  # a key that the check needs is wrong
            if whole:
                raise
    return found


def _told(time: float, scene: SceneModel, digits: str = "g") -> str:
    return told(time, "a/U", scene.scales, digits=digits)


def _whole_run(scene: SceneModel) -> None:
    _check_whole_steps("run.duration", scene.run.duration, scene)


def _whole_record(scene: SceneModel) -> None:
    every, run = scene.record.every, scene.run
    if every is None:
        return
    _check_whole_steps("record.every", every, scene)
    if round(every / run.time_step) > round(run.duration / run.time_step):
        most, found = _told(run.duration, scene), _told(every, scene)
        raise KeyedError("record.every", f"expected at most run.duration ({most}), found {found}")


def _burn_in(scene: SceneModel) -> None:
    burn_in, run = scene.record.burn_in, scene.run
    if burn_in >= run.duration:
        most, found = _told(run.duration, scene), _told(burn_in, scene)
        raise KeyedError("record.burn_in", f"expected less than run.duration ({most}), found {found}")
    if burn_in > 0.0:
        _check_whole_steps("record.burn_in", burn_in, scene)


def _check_whole_steps(key: str, time: float, scene: SceneModel) -> None:
    """Raise a `KeyedError` for `key` unless `time` is a whole number of steps, within 1e-6 of a step."""
    time_step = scene.run.time_step
    steps = time / time_step
    nearest = max(1, round(steps))
    if abs(steps - nearest) > 1e-6:
        message = f"{_told(time, scene, '.12g')} is not a whole number of steps of {_told(time_step, scene)}"
        raise KeyedError(key, f"{message}: the nearest is {_told(nearest * time_step, scene, '.12g')}")


def _step_can_be_added(scene: SceneModel) -> None:
    """The turn of one step must not vanish in the rounding of a director; positions carry what rounding left."""
    step, D_r, spacing = scene.run.time_step, scene.rotational_diffusion, _SPACING[scene.precision]
    least = _WELL_ADDED * spacing
    if D_r > 0.0:
        least = min(least, (_WELL_KICKED * spacing) ** 2 / (2.0 * D_r))
    if step < least:
        remedy = "; or set run.precision: f64" if scene.precision == "f32" else ""
        raise KeyedError(
            "run.time_step",
            f"expected at least {_told(least, scene, '.2g')} in {scene.precision}, in which shorter steps turn a "
            f"swimmer by less than rounding does, found {_told(step, scene)}{remedy}",
        )


def _flights(scene: SceneModel) -> None:
    """Steps must be able to grow to `run.flight_step`."""
    key, run, D_r = "run.flight_step", scene.run, scene.rotational_diffusion
    length = run.flight_step
    if length is None:
        return
    if scene.integrator != "reflected":
        raise KeyedError(key, f"flights are for the integrator reflected, which has noise: found {scene.integrator}")
    if length * D_r > _MOST_TURN:
        most, found = _told(_MOST_TURN / D_r, scene, ".3g"), _told(length, scene)
        raise KeyedError(key, f"expected at most {most}, in which a swimmer turns little, found {found}")
    _check_whole_steps(key, length, scene)
    longest = LONGEST_LAUNCH.get(run.device, LONGEST_LAUNCH["cpu"])
    if round(length / run.time_step) > longest:
        most, step, found = (_told(time, scene) for time in (longest * run.time_step, run.time_step, length))
        raise KeyedError(key, f"expected at most {most}, {longest:,} steps of {step}, found {found}")
    for other, time in (("run.duration", run.duration), ("record.every", scene.record.every)):
        if time is not None and abs(time / length - max(1, round(time / length))) > 1e-6:
            whole, found = _told(time, scene), _told(length, scene)
            raise KeyedError(key, f"expected a whole part of {other} ({whole}), found {found}")


def _obstacles(scene: SceneModel) -> None:
    scene.obstacles.check(scene.domain)


def _release(scene: SceneModel) -> None:
    scene.swimmers.release.check(scene.domain)


def _encounter(scene: SceneModel) -> None:
    scene.encounter.check()


def _integrator(scene: SceneModel) -> None:
    noisy = isinstance(scene.noise, Brownian)
    if scene.run.integrator == "located" and (noisy or scene.run.precision == "f32"):
        raise KeyedError("run.integrator", "located is for runs without noise in f64: expected euler or auto")
    if scene.run.integrator == "reflected" and not noisy:
        raise KeyedError("run.integrator", "reflected is for runs with noise: expected located, euler or auto")


def _motility(scene: SceneModel) -> None:
    motility, run = scene.swimmers.motility, scene.run
    if run.integrator == "located" and motility.reorients():
        raise KeyedError(
            "run.integrator",
            f"located is for swimmers that do not turn by themselves, as the motility {motility.kind} makes them do: "
            "expected euler or auto",
        )
    if run.flight_step is not None and not isinstance(motility, Steady):
        raise KeyedError("run.flight_step", f"flights are for the motility steady: found {motility.kind}")


_CHECKS: tuple[Callable[[SceneModel], None], ...] = (
    _whole_run, _whole_record, _burn_in, _step_can_be_added, _flights, _obstacles, _release, _encounter, _integrator,
    _motility,
)  # fmt: skip
