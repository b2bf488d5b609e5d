"""The layout in which a recording opens: pages that go from the whole to the detail, each of what there is."""

from __future__ import annotations

from dataclasses import dataclass

import rerun.blueprint as rrb

from porous_swim.core.scales import Scales
from porous_swim.observers.rerun.plots import Plots
from porous_swim.observers.rerun.space import Space
from porous_swim.observers.rerun.timeline import TimeLine


@dataclass(frozen=True)
class Layout:
    """What there is to show."""

    space: Space
    timeline: TimeLine
    scales: Scales | None
    has_colloids: bool
    has_trails: bool
    followed: int | None  # the swimmer that has a page
    distributions: tuple[str, ...]  # that have something to show

    def blueprint(self) -> rrb.Blueprint:
        """The layout as Rerun takes it."""
        pages: list[rrb.Container] = [self._medium()]
        if self.followed is not None:
            pages.append(self._one(self.followed))
        if "hop_time" in self.distributions:
            pages.append(self._network())
        if self.distributions:
            pages.append(self._distributions())
        pages.append(rrb.Horizontal(_summary(), _log(), column_shares=[3, 2], name="Summary"))
        return rrb.Blueprint(
            rrb.Tabs(*pages, active_tab=0),
            rrb.BlueprintPanel(state="collapsed"),
            rrb.SelectionPanel(state="collapsed"),
            self.timeline.panel(self.space.duration),
        )

    @property
    def _plots(self) -> Plots:
        return Plots(self.space.duration, self.timeline, self.scales)

    def _medium(self) -> rrb.Horizontal:
        views = [self.space.recorded(), *([self.space.tracked()] if self.has_trails else [])]
        space = rrb.Tabs(*views, active_tab=int(self.space.crowded)) if len(views) > 1 else views[0]
        panels: list[rrb.Container | rrb.View] = [self._series()]
        if self.distributions:
            panels.append(self._plots.tabs(self.distributions))
        panels.append(_summary())
        shares = [3, 3, 4] if self.distributions else [1, 1]  # the text needs most room
        return _page("Medium and swimmers", space, rrb.Vertical(*panels, row_shares=shares))

    def _series(self) -> rrb.Tabs:
        plots = self._plots
        if not self.has_colloids:
            return rrb.Tabs(plots.msd())
        views: list[rrb.View] = [plots.fractions(), plots.events(), plots.msd()]
        if self.has_trails:
            views.append(plots.states())
        return rrb.Tabs(*views, active_tab=0)

    def _one(self, swimmer: int) -> rrb.Horizontal:
        plots = self._plots
        panels = rrb.Vertical(plots.height(), plots.pitch(), plots.state(swimmer), row_shares=[3, 3, 2])
        return _page("One swimmer", self.space.followed(swimmer), panels)

    def _network(self) -> rrb.Horizontal:
        caption = rrb.TextDocumentView(name="Network", origin="/network")
        panels = rrb.Vertical(caption, self._plots.events(), self._plots.bars("hop_time"), row_shares=[2, 3, 3])
        return _page("Hop network", self.space.hops(), panels)

    def _distributions(self) -> rrb.Grid:
        columns = min(2, len(self.distributions))
        return rrb.Grid(*map(self._plots.bars, self.distributions), grid_columns=columns, name="Distributions")


def _page(name: str, space: rrb.Container | rrb.View, panels: rrb.Vertical) -> rrb.Horizontal:
    return rrb.Horizontal(space, panels, column_shares=[3, 2], name=name)


def _summary() -> rrb.TextDocumentView:
    return rrb.TextDocumentView(name="Summary", origin="/summary")


def _log() -> rrb.TextLogView:
    return rrb.TextLogView(name="Log", origin="/log")
