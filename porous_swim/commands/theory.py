"""The predictions of `analysis.theory` as a table: what `porous-swim theory` prints."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from functools import partial
from typing import Any, Literal

from porous_swim import theory
from porous_swim.core.errors import SceneError

ORDERS: tuple[Literal["exact"], Literal["leading"]] = ("exact", "leading")
TRAPPING_ORDERS: tuple[Literal["integral"], Literal["estimate"]] = ("integral", "estimate")


@dataclass(frozen=True)
class Prediction:
    """One line: a quantity to one order."""

    quantity: str
    order: str
    value: float | None  # None: there is none, for the reason in `note`
    unit: str
    note: str = ""

    def as_dict(self) -> dict[str, Any]:
        """For JSON, which has no infinity: there it is the text `infinite`."""
        value = "infinite" if self.value is not None and math.isinf(self.value) else self.value
        return {**asdict(self), "value": value}

    @property
    def text(self) -> str:
        """The value with its unit, or why there is none."""
        number = "none" if self.value is None else "infinite" if math.isinf(self.value) else f"{self.value:.6g}"
        return " ".join(part for part in (number, self.unit if self.value is not None else "", self.note) if part)


def predictions(
    dipole_strength: float, aspect_ratio: float, radius: float | None, diffusion: float | None
) -> list[Prediction]:
    """All that can be said of a swimmer; more with a `radius` A, and with noise D (D_r = 3 D/4).

    Raises:
        SceneError: an argument is out of its range.
    """
    alpha, gamma = dipole_strength, aspect_ratio
    if diffusion is not None and not 0.0 < diffusion < math.inf:
        raise SceneError(f"theory: diffusion: found {diffusion:g}, allowed are finite numbers above 0")
    try:
        rows = list(_capture(alpha, gamma, radius))
        if radius is not None and alpha > 0.0:
            rows += _sliding(alpha, gamma, radius)
            if diffusion is not None:
                rows += _trapping(alpha, gamma, radius, diffusion)
    except ValueError as error:
        raise SceneError(f"theory: {error}") from None
    except ArithmeticError:
        sentence = "theory: found numbers whose powers are beyond double precision, allowed are sizes of 1e-20 to 1e20"
        raise SceneError(sentence) from None
    return rows


def _try(
    quantity: str, order: str, unit: str, compute: Callable[[], float | None], note: str = "", *, absent: str = ""
) -> Prediction:
    """A prediction whose formula may not hold for these arguments; `absent` says why it may have no value."""
    try:
        value = compute()
        return Prediction(quantity, order, value, unit, absent if value is None else note)
    except ValueError as error:
        return Prediction(quantity, order, None, unit, f"({error})")


def _capture(alpha: float, gamma: float, A: float | None) -> Iterator[Prediction]:
    for order in ORDERS:
        theory.critical_radius(alpha, gamma, order="leading")  # arguments out of range end the table here
        yield _try("critical radius", order, "a", partial(theory.critical_radius, alpha, gamma, order=order))
    if alpha > 0.0 and gamma == 1.0:
        yield _try("critical radius", "improved", "a", lambda: theory.critical_radius(alpha, order="improved"))
    where = "at a plane" if A is None else ""
    if alpha > 0.0:
        for order in ORDERS:
            yield _try(
                "escape angle", order, "rad",
                partial(theory.escape_angle, alpha, math.inf if A is None else A, gamma, order=order),
                where if order == "exact" else "",
            )  # fmt: skip
    if A is None:
        return
    for order in ORDERS:
        pitch = partial(theory.equilibrium_pitch, alpha, A, gamma, order=order)
        yield _try("equilibrium pitch", order, "rad", pitch, absent="(not held)")
    if alpha > 0.0 and gamma == 1.0:
        yield Prediction("basin depth", "leading", theory.basin_depth(alpha, A), "a", "(measured: 3 to 5 % less)")


def _sliding(alpha: float, gamma: float, A: float) -> Iterator[Prediction]:
    yield _try("sliding time from pitch 0", "near wall", "a/U", lambda: theory.sliding_time(alpha, A, gamma))
    if math.isinf(A):  # around a plane wall nobody winds, and past it nobody swims
        return
    yield _try("winding from pitch 0", "near wall", "turns", lambda: theory.winding(alpha, A, gamma))
    if gamma == 1.0:
        for share in (0.25, 0.5, 1.0):
            angle = partial(_scattering, alpha, A, share * A)
            yield _try(f"scattering angle at y0 = {share * A:g}", "near wall", "degrees", angle, absent="(held)")


def _scattering(alpha: float, A: float, impact_parameter: float) -> float | None:
    """The scattering angle in degrees."""
    angle = theory.scattering_angle(alpha, A, impact_parameter)
    return None if angle is None else math.degrees(angle)


def _trapping(alpha: float, gamma: float, A: float, D: float) -> Iterator[Prediction]:
    for order in TRAPPING_ORDERS:
        found = theory.trapping_warnings(alpha, A, 0.75 * D, gamma, order=order)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # the note says it
            time = theory.mean_trapping_time(alpha, A, 0.75 * D, gamma, order=order)
        note = f"(out of its range: {'; '.join(found)})" if found else ""
        yield Prediction("mean trapping time", order, time, "a/U", note)
