"""The space that holds colloids and swimmers."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import Field, PrivateAttr, ValidationInfo, model_validator

from porous_swim.core.parts import LEAST_RADIUS, LONGEST, UNITS_UNKNOWN, KeyedError, Length, Part, as_vector
from porous_swim.core.scales import Scales

MOST_COLLOIDS = 10**8  # about 3 GB of centres and radii

Edge = Annotated[Length, Field(ge=LEAST_RADIUS, le=LONGEST)]


class Domain(Part):
    """The space that holds colloids and swimmers."""

    dimensions: Literal[2, 3] = 3
    """2: everything moves in the plane z = 0, between colloids that are still spheres. 3: all of space."""
    boundary: Literal["open", "periodic"] | None = None
    """`open` is unbounded, `periodic` repeats. Left out: open for `none`, `single` and `wall`, else periodic."""
    size: Annotated[tuple[Edge, ...], Field(min_length=2, max_length=3)] | None = None
    """Edges of the box, where the layout does not set it: `[x, y]` in 2-D, `[x, y, z]` in 3-D."""

    _scales: Scales | None = PrivateAttr(None)

    @model_validator(mode="after")
    def _remember_units(self, info: ValidationInfo) -> Domain:
        units = (info.context or {}).get("units")
        if units is not None and units != UNITS_UNKNOWN:
            self._scales = Scales(units.length, units.time)
        return self

    @property
    def scales(self) -> Scales | None:
        """What a and a/U are in the laboratory, for messages; None where the scene has no units."""
        return self._scales

    @property
    def periodic(self) -> bool:
        """Whether the box repeats."""
        return self.boundary == "periodic"

    def sized_box(self) -> np.ndarray:
        """Return (3,) the edges from `size`, 0 along z in 2-D; a `KeyedError` where `size` does not fit."""
        if self.size is None:
            raise KeyedError("domain.size", f"this layout needs the box: give {self.dimensions} edge lengths")
        if len(self.size) != self.dimensions:
            message = f"expected {self.dimensions} edge lengths in {self.dimensions}-D, found {len(self.size)}"
            raise KeyedError("domain.size", message)
        return as_vector([*self.size, 0.0][:3], key="domain.size", dimensions=self.dimensions)

    def refuse_size(self, reason: str) -> None:
        """Raise a `KeyedError` if `size` is given although something else sets the box."""
        if self.size is not None:
            raise KeyedError("domain.size", f"leave it out: {reason}")
