"""The views of space in a recording: which entities each shows, and from where. Lengths in a."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import rerun.blueprint as rrb

from porous_swim.observers.rerun.above import from_above
from porous_swim.observers.rerun.palette import GROUND
from porous_swim.observers.rerun.timeline import TimeLine
from porous_swim.observers.rerun.view import Scenery

WORLD = "/world"
_TRAIL_SHARE = 0.35  # a trail's length over the box: a few colloids long, short of a tangle
_LONE_TRAIL = 2.0  # likewise, of a swimmer on its own


@dataclass(frozen=True)
class Space:
    """The scenery of a run and what is in it."""

    scenery: Scenery
    close: Scenery  # around the swimmer that is followed
    timeline: TimeLine
    duration: float  # a/U
    periodic: bool
    flat: bool  # whether no colloid can hide a swimmer: in a plane, or behind none
    crowded: bool  # whether colloids are too many to see through: beside trails show only those visited

    def recorded(self) -> rrb.View:
        """All recorded swimmers among all colloids."""
        shown = ["colloids", "scale", "swimmers", "tracked/directors", "tracked/trails"]
        return self._view("All recorded swimmers", shown, trails="tracked", length=_TRAIL_SHARE)

    def tracked(self) -> rrb.View:
        """The swimmers that leave a trail."""
        shown = [self._beside, "scale", "tracked/**"]
        return self._view("Tracked swimmers", shown, trails="tracked", length=_TRAIL_SHARE)

    def followed(self, swimmer: int) -> rrb.View:
        """One swimmer and where it came from."""
        # in a plane nothing hides it; in space only the colloids that it was near are shown, a part of `followed`
        shown = ["colloids", "followed/**"] if self.flat else ["followed/**"]
        return self._view(f"Swimmer {swimmer}", shown, trails="followed", length=_LONE_TRAIL, scenery=self.close)

    def hops(self) -> rrb.View:
        """The network of hops over the colloids."""
        return self._view("Hop network", ["colloids", "scale", "hops"])

    @property
    def _beside(self) -> str:
        return "visited" if self.crowded else "colloids"

    def _view(
        self, name: str, shown: Sequence[str], *, trails: str | None = None, length: float = 0.0,
        scenery: Scenery | None = None,
    ) -> rrb.View:  # fmt: skip
        scenery = scenery or self.scenery
        contents = [WORLD, f"{WORLD}/domain", *(f"{WORLD}/{entity}" for entity in shown)]
        overrides: dict[Any, Any] = {} if trails is None else {f"{WORLD}/{trails}/trails": self._trail_time(length)}
        if scenery.dimensions == 2:
            return from_above(name, contents, scenery, self.scenery, overrides, GROUND)
        position, up = scenery.eye()
        eye = rrb.EyeControls3D(kind=rrb.Eye3DKind.Orbital, position=position, look_target=scenery.center, eye_up=up)
        return rrb.Spatial3DView(
            name=name,
            origin=WORLD,
            contents=contents,
            background=GROUND,
            eye_controls=eye,
            line_grid=rrb.LineGrid3D(visible=False),
            overrides=overrides,
        )

    def _trail_time(self, share: float) -> rrb.VisibleTimeRanges:
        # at speed 1 a length is a time; where nothing repeats paths do not overlap, so show all of them
        length = share * self.scenery.size if self.periodic else np.inf
        return self.timeline.last(length if length < self.duration else None)
