"""The layout in which a recording opens: space on the left, what is counted on the right."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from porous_swim.observers.palette import GROUND
from porous_swim.observers.stream import TIME
from porous_swim.observers.view import Scenery

_SHOW_SECONDS = 40.0  # time in which the viewer plays a whole run
_TRAIL_SHARE = 0.35  # a trail's length over the box: a few colloids long, short of a tangle


@dataclass(frozen=True)
class Layout:
    """What there is to show."""

    scenery: Scenery
    duration: float  # a/U
    periodic: bool
    has_colloids: bool
    has_trails: bool
    crowded: bool  # whether colloids are too many to see through: open on the tracked swimmers

    def blueprint(self) -> rrb.Blueprint:
        """The layout as Rerun takes it."""
        panels = [self._series(), *([self._histograms()] if self.has_colloids else []), _texts()]
        shares = [3, 3, 4] if self.has_colloids else [1, 1]  # the texts need most room
        return rrb.Blueprint(
            rrb.Horizontal(self._space(), rrb.Vertical(*panels, row_shares=shares), column_shares=[3, 2]),
            rrb.BlueprintPanel(state="collapsed"),
            rrb.SelectionPanel(state="collapsed"),
            # the recording plays as it opens: trails and counts grow from the start
            rrb.TimePanel(
                state="collapsed",
                timeline=TIME,
                play_state="playing",
                loop_mode="all",
                playback_speed=float(f"{max(self.duration, 1e-9) / _SHOW_SECONDS:.1g}"),
            ),
        )

    def _space(self) -> rrb.Container | rrb.View:
        all_swimmers = ["$origin/**", "- /world/tracked/swimmers", "- /world/visited"]
        views = [self._world("All recorded swimmers", all_swimmers)]
        if self.has_trails:
            tracked = ["$origin/**", "- /world/swimmers"]
            tracked.append("- /world/colloids" if self.crowded else "- /world/visited")
            views.append(self._world("Tracked swimmers", tracked))
        return rrb.Tabs(*views, active_tab=int(self.crowded)) if len(views) > 1 else views[0]

    def _world(self, name: str, contents: list[str]) -> rrb.Spatial3DView:
        position, up = self.scenery.eye()
        eye = rrb.EyeControls3D(
            kind=rrb.Eye3DKind.Orbital, position=position, look_target=self.scenery.center, eye_up=up
        )
        return rrb.Spatial3DView(
            name=name,
            origin="/world",
            contents=contents,
            background=GROUND,
            eye_controls=eye,
            line_grid=rrb.LineGrid3D(visible=False),
            overrides={"/world/tracked/trails": [self._trail_time()]},
        )

    def _trail_time(self) -> rrb.VisibleTimeRanges:
        # at speed 1 a length is a time; where nothing repeats paths do not overlap, so show all of them
        length = _TRAIL_SHARE * self.scenery.size if self.periodic else np.inf
        start = (
            rrb.TimeRangeBoundary.cursor_relative(seconds=-length)
            if length < self.duration
            else rrb.TimeRangeBoundary.infinite()
        )
        return rrb.VisibleTimeRanges(timeline=TIME, start=start, end=rrb.TimeRangeBoundary.cursor_relative(seconds=0))

    def _series(self) -> rrb.Tabs:
        whole = rr.TimeRange(
            start=rrb.TimeRangeBoundary.absolute(seconds=0),
            end=rrb.TimeRangeBoundary.absolute(seconds=self.duration),
        )
        axis = rrb.TimeAxis(view_range=whole)
        legend = rrb.PlotLegend(rrb.Corner2D.RightTop)

        def plot(name: str, origin: str, *, axis_y: rrb.ScalarAxis | None = None) -> rrb.TimeSeriesView:
            return rrb.TimeSeriesView(name=name, origin=origin, axis_x=axis, axis_y=axis_y, plot_legend=legend)

        msd = plot("MSD (a²)", "/series/msd")
        if not self.has_colloids:
            return rrb.Tabs(msd)
        views: list[rrb.View] = [
            plot("Fractions", "/series/fraction", axis_y=rrb.ScalarAxis(range=(0.0, 1.05))),
            plot("Hops and returns", "/series/events"),
            msd,
        ]
        if self.has_trails:
            views.append(rrb.StateTimelineView(name="States", origin="/states", time_view=axis))
        return rrb.Tabs(*views, active_tab=0)

    def _histograms(self) -> rrb.Tabs:
        no_legend = rrb.PlotLegend(visible=False)
        titles = {
            "residence": "Residence time (a/U)",
            "winding": "Winding (turns)",
            "hop_time": "Hop time (a/U)",
        }
        views = [
            rrb.BarChartView(name=title, origin=f"/histograms/{name}", plot_legend=no_legend)
            for name, title in titles.items()
        ]
        return rrb.Tabs(*views, active_tab=0)


def _texts() -> rrb.Tabs:
    return rrb.Tabs(
        rrb.TextDocumentView(name="Summary", origin="/summary"),
        rrb.TextLogView(name="Log", origin="/log"),
        active_tab=0,
    )
