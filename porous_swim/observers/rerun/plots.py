"""The plots of a recording: series over time, lanes of states, and bars."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import rerun.blueprint as rrb

from porous_swim.core.scales import Scales, shown_in
from porous_swim.observers.rerun.lanes import lane_of
from porous_swim.observers.rerun.timeline import TimeLine

_NONE = rrb.PlotLegend(visible=False)
_RISING, _LEVEL = rrb.PlotLegend(rrb.Corner2D.LeftTop), rrb.PlotLegend(rrb.Corner2D.RightTop)  # clear of the lines
_TABS = {"residence": "Residence", "survival": "Survival", "winding": "Winding", "hop_time": "Hop time"}
_AXES = {  # what a bar's height is, and what it stands over, with the unit of that
    "residence": ("encounters that ended", "residence time", "a/U"),
    "survival": ("share of encounters that last longer", "time", "a/U"),
    "winding": ("encounters that ended", "winding", "turns"),
    "hop_time": ("hops", "hop time", "a/U"),
}


@dataclass(frozen=True)
class Plots:
    """Plots over the time of a run of `duration`, a/U."""

    duration: float
    timeline: TimeLine
    scales: Scales | None

    def fractions(self) -> rrb.TimeSeriesView:
        """Shares of the swimmers in each state."""
        return self._series("Fractions", "/series/fraction", axis_y=rrb.ScalarAxis(range=(0.0, 1.05)), legend=_LEVEL)

    def events(self) -> rrb.TimeSeriesView:
        """Hops and returns per swimmer."""
        return self._series("Hops and returns", "/series/events", legend=_RISING)

    def msd(self) -> rrb.TimeSeriesView:
        """Mean squared displacement."""
        return self._series(f"MSD ({shown_in('a^2', self.scales)[1]})", "/series/msd", legend=_RISING)

    def height(self) -> rrb.TimeSeriesView:
        """Height of the followed swimmer."""
        _, unit = shown_in("a", self.scales)
        return self._series(f"Height above the nearest colloid ({unit})", "/followed/height")

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
        return rrb.TimeAxis(view_range=self.timeline.whole(self.duration))

    def bars(self, name: str) -> rrb.BarChartView:
        """The distribution of that name; its title names the axes, which the viewer cannot."""
        upwards, along, unit = _AXES[name]
        title = f"↑ {upwards}   → {along} ({shown_in(unit, self.scales)[1]})"
        return rrb.BarChartView(name=title, origin=f"/histograms/{name}", plot_legend=_NONE)

    def tabs(self, names: Sequence[str]) -> rrb.Tabs:
        """Several distributions in one place."""
        return rrb.Tabs(*(rrb.Vertical(self.bars(name), name=_TABS[name]) for name in names), active_tab=0)

    def _series(
        self, name: str, origin: str, *, axis_y: rrb.ScalarAxis | None = None, legend: rrb.PlotLegend = _NONE
    ) -> rrb.TimeSeriesView:
        return rrb.TimeSeriesView(name=name, origin=origin, axis_x=self._axis, axis_y=axis_y, plot_legend=legend)
