"""What is compiled into the kernels: the one argument of every `make_*`. All numbers stay arguments of the kernels.

It stands here, below everything that is compiled, as `physics`, `obstacles.search` and `engine.kernel` all take it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

Shape = Literal["sphere", "flat", "rod", "needle"]  # of swimmers, as their contact needs it: see `contact.shape_of`
Surface = Literal["sphere", "plane"]  # of obstacles
Variates = Literal["gaussian", "uniform"]


def has_partners(shape: str, integrator: str) -> bool:
    """Whether lanes know a second colloid: those of rods, whose contact with it depends on how they stand to it."""
    return shape in ("rod", "needle") and integrator != "located"


@dataclass(frozen=True)
class Model:
    """What a kernel is compiled for, and the key under which it is kept: a sweep over numbers compiles once."""

    real: Any  # ti.f32 or ti.f64
    dimensions: int = 3
    surface: Surface = "sphere"
    shape: Shape = "sphere"
    flows: tuple[type, ...] = ()  # whose sum is the drift
    motility: Any = None  # the model of how they swim and turn by themselves
    numbers: tuple[str, ...] = ()  # names of the numbers of a swimmer, in the order of the table of parameter sets
    variates: Variates | None = None  # None without noise
    integrator: str = "euler"  # or "reflected", "located"
    flights: bool = False  # whether steps grow far from every colloid
    lanes: int = 1  # swimmers to a block

    @property
    def at_rest(self) -> Model:
        """The model of kernels that only look at swimmers, one for all that moves them."""
        return Model(self.real, self.dimensions, self.surface, self.shape, numbers=self.numbers)

    @property
    def sphere(self) -> bool:
        """Whether swimmers are spheres, whose contact height is 1 everywhere."""
        return self.shape == "sphere"

    @property
    def located(self) -> bool:
        """Whether steps end at events; else events fall on whole steps, or into their middle."""
        return self.integrator == "located"

    @property
    def reflected(self) -> bool:
        """Whether walls hold a swimmer, and thresholds are passed, as by a continuous path."""
        return self.integrator == "reflected"

    @property
    def partners(self) -> bool:
        """Whether lanes know a second colloid."""
        return has_partners(self.shape, self.integrator)
