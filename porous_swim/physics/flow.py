"""What a flow is: the drift of a swimmer that the nearest colloid causes."""

# No `from __future__ import annotations`: Taichi needs live annotations in kernel modules.
from abc import abstractmethod
from typing import TYPE_CHECKING, ClassVar

from porous_swim.core.numbers import Given
from porous_swim.core.registry import OpenPart
from porous_swim.physics.model import Model


class Flow(OpenPart):
    """The flow that a colloid reflects onto a swimmer: a frozen model, chosen by `kind` in `hydrodynamics`."""

    if TYPE_CHECKING:
        kind: str
    NUMBERS: ClassVar[tuple[str, ...]] = ("alpha", "bretherton")
    """The dipole strength, and Bretherton's constant, by which a flow turns elongated swimmers; or a flow's own."""

    def numbers(self, given: Given) -> dict[str, float]:
        """Return a value for each of `NUMBERS`."""
        return {"alpha": given.dipole_strength, "bretherton": given.bretherton}

    @staticmethod
    @abstractmethod
    def make_drift(model: Model):
        """Return the Taichi function `drift(x, e, A, law) -> velocity, director rate` for a model.

        `x` is the offset from the centre of a sphere of radius `A` (from the foot on a wall, where `model.surface` is
        `plane`), a; `e` the unit director. `law` holds the numbers that the flow declares in `NUMBERS` and hands over
        in `numbers`, by name, as `law.alpha`. The velocity, in U, is that of the flow alone, without the swimmer's own
        speed; the rate, in U/a, is across `e`.

        The numbers are wide values, one for each lane, or plain ones: no branches, constants as `model.real(0.5)`,
        vectors before numbers in products, no assignment in place; `physics.vectors.by_lane` for functions that Taichi
        has for plain numbers alone. Flights (`run.flight_step`) rely on a flow that is at most
        3 |alpha|/(4 h^2) fast at heights h above 2. Decorate with `@staticmethod` and `@functools.cache`.
        """
