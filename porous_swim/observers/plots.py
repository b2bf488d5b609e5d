"""The plots of a recording: series over time, lanes of states, and bars."""

from __future__ import annotations

from dataclasses import dataclass

import rerun as rr
import rerun.blueprint as rrb

from porous_swim.observers.lanes import lane_of

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
        return self._series("Fractions", "/series/fraction", axis_y=rrb.ScalarAxis(range=(0.0, 1.05)))

    def events(self) -> rrb.TimeSeriesView:
        """Hops and returns per swimmer."""
        return self._series("Hops and returns", "/series/events")

    def msd(self) -> rrb.TimeSeriesView:
        """Mean squared displacement."""
        return self._series("MSD (a²)", "/series/msd")

    def height(self) -> rrb.TimeSeriesView:
        """Height of the followed swimmer."""
        return self._series("Height above the nearest colloid (a)", "/followed/height", legend=False)

    def pitch(self) -> rrb.TimeSeriesView:
        """Pitch of the followed swimmer."""
        axis = rrb.ScalarAxis(range=(-1.6, 1.6))
        return self._series("Pitch (rad), above 0 away from the colloid", "/followed/pitch", axis_y=axis, legend=False)

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
        self, name: str, origin: str, *, axis_y: rrb.ScalarAxis | None = None, legend: bool = True
    ) -> rrb.TimeSeriesView:
        shown = rrb.PlotLegend(rrb.Corner2D.RightTop, visible=legend)
        return rrb.TimeSeriesView(name=name, origin=origin, axis_x=self._axis, axis_y=axis_y, plot_legend=shown)


def bars(name: str) -> rrb.BarChartView:
    """The distribution of that name."""
    return rrb.BarChartView(name=_TITLES[name], origin=f"/histograms/{name}", plot_legend=rrb.PlotLegend(visible=False))
