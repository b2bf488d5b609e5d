"""The plots of a recording: series over time, lanes of states, and bars."""

from __future__ import annotations

from dataclasses import dataclass

import rerun as rr
import rerun.blueprint as rrb

from porous_swim.observers.lanes import lane_of

_NONE = rrb.PlotLegend(visible=False)
_RISING, _LEVEL = rrb.PlotLegend(rrb.Corner2D.LeftTop), rrb.PlotLegend(rrb.Corner2D.RightTop)  # clear of the lines
_TITLES = {
    "residence": "Residence time (a/U)",
    "winding": "Winding (turns)",
    "hop_time": "Hop time (a/U)",
    "survival": "Share of encounters that last longer (a/U)",
}


@dataclass(frozen=True)
class Plots:
    """Plots over the time of a run of `duration`, a/U."""

    duration: float

    def fractions(self) -> rrb.TimeSeriesView:
        """Shares of the swimmers in each state."""
        return self._series("Fractions", "/series/fraction", axis_y=rrb.ScalarAxis(range=(0.0, 1.05)), legend=_LEVEL)

    def events(self) -> rrb.TimeSeriesView:
        """Hops and returns per swimmer."""
        return self._series("Hops and returns", "/series/events", legend=_RISING)

    def msd(self) -> rrb.TimeSeriesView:
        """Mean squared displacement."""
        return self._series("MSD (a²)", "/series/msd", legend=_RISING)

    def height(self) -> rrb.TimeSeriesView:
        """Height of the followed swimmer."""
        return self._series("Height above the nearest colloid (a)", "/followed/height")

    def pitch(self) -> rrb.TimeSeriesView:
        """Pitch of the followed swimmer."""
        axis = rrb.ScalarAxis(range=(-1.6, 1.6))
        return self._series("Pitch (rad), above 0 away from the colloid", "/followed/pitch", axis_y=axis)

    def states(self) -> rrb.StateTimelineView:
        """Lanes of all swimmers that have one."""
        return rrb.StateTimelineView(name="States", origin="/states", time_view=self._axis)

    def state(self, swimmer: int) -> rrb.StateTimelineView:
        """The lane of one swimmer."""
        return rrb.StateTimelineView(name="State", origin=f"/{lane_of(swimmer)}", time_view=self._axis)

    @property
    def _axis(self) -> rrb.TimeAxis:
        boundary = rrb.TimeRangeBoundary.absolute
        whole = rr.TimeRange(start=boundary(seconds=0), end=boundary(seconds=self.duration))
        return rrb.TimeAxis(view_range=whole)

    def _series(
        self, name: str, origin: str, *, axis_y: rrb.ScalarAxis | None = None, legend: rrb.PlotLegend = _NONE
    ) -> rrb.TimeSeriesView:
        return rrb.TimeSeriesView(name=name, origin=origin, axis_x=self._axis, axis_y=axis_y, plot_legend=legend)


def bars(name: str) -> rrb.BarChartView:
    """The distribution of that name."""
    return rrb.BarChartView(name=_TITLES[name], origin=f"/histograms/{name}", plot_legend=_NONE)
