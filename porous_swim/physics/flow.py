"""What a flow is: the drift of a swimmer that the nearest colloid causes."""

# No `from __future__ import annotations`: Taichi needs live annotations in kernel modules.
from abc import abstractmethod
from typing import TYPE_CHECKING

from porous_swim.core.registry import OpenPart
from porous_swim.physics.surface import Surface


class Flow(OpenPart):
    """The flow that a colloid reflects onto a swimmer: a frozen model, chosen by `kind` in `hydrodynamics`."""

    if TYPE_CHECKING:
        kind: str

    @staticmethod
    @abstractmethod
    def make_drift(real, surface: Surface = "sphere"):
        """Return the Taichi function `drift(x, e, A, alpha, Gamma) -> velocity, director rate`, one for each `real`.

        `x` is the offset from the centre of a sphere of radius `A` (from the foot on a wall, where `surface` is
        `plane`), a; `e` the unit director; `alpha` the dipole strength, `Gamma` Bretherton's constant. The velocity, in
        U, is that of the flow alone, without the swimmer's own speed; the rate, in U/a, is across `e`.

        The numbers are wide values, one for each lane, or plain ones: no branches, constants as `real(0.5)`, vectors
        before numbers in products, no assignment in place. Flights (`run.flight_step`) rely on a flow that is at most
        3 |alpha|/(4 h^2) fast at heights h above 2. Decorate with `@staticmethod` and `@functools.cache`.
        """
