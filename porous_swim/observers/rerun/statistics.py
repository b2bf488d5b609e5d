"""What is counted, in a recording: lines over time and histograms that grow."""

from __future__ import annotations

import numpy as np
import rerun as rr

from porous_swim.analysis.lifetimes.survival import survival_curve
from porous_swim.core.scales import Scales, shown_in
from porous_swim.core.state import State, restore_parts, state_of
from porous_swim.observers.base import BOUND, CONTACT, FREE, Frame
from porous_swim.observers.rerun.histogram import GrowingHistogram
from porous_swim.observers.rerun.palette import BAR_COLOR, HOP_COLOR, MSD_COLOR, RETURN_COLOR, STATE_COLORS
from porous_swim.observers.rerun.pictures import Pictures
from porous_swim.observers.rerun.stream import BATCH_ROWS, Moments, RecordingFile

_SURVIVAL_BARS = 64
DISTRIBUTIONS = "residence", "survival", "winding", "hop_time"
_WINDING_RESOLUTION = 1.0 / 1024.0  # turns; a power of two, so that whole turns are edges

_LINES = {
    "fraction/free": ("free", STATE_COLORS[FREE]),
    "fraction/bound": ("bound, not in contact", STATE_COLORS[BOUND]),
    "fraction/contact": ("in contact", STATE_COLORS[CONTACT]),
    "events/hops": ("hops per swimmer", HOP_COLOR),
    "events/returns": ("returns per swimmer", RETURN_COLOR),
    "msd": ("from the start, all swimmers", MSD_COLOR),
}


class SeriesTrack:
    """Fractions, mean squared displacement, hops and returns, over all swimmers."""

    def __init__(self, file: RecordingFile, scales: Scales | None) -> None:
        self._file = file
        self._area, _ = shown_in("a^2", scales)
        self._moments = Moments()
        self._rows: list[tuple[float, ...]] = []
        for entity, (label, color) in _LINES.items():
            file.log(f"series/{entity}", rr.SeriesLines(colors=[color], names=[label], widths=[2.0]))

    def observe(self, frame: Frame) -> None:
        """Take in one frame."""
        everyone = frame.ensemble
        n_swimmers = max(everyone.n_swimmers, 1)
        values = (
            1.0 - everyone.fraction_bound,
            everyone.fraction_bound - everyone.fraction_contact,
            everyone.fraction_contact,
            frame.counts.n_hops / n_swimmers,
            frame.counts.n_returns / n_swimmers,
            everyone.msd * self._area,
        )
        self._moments.add(frame)
        self._rows.append(values)
        if len(self._rows) >= BATCH_ROWS:
            self.finish()

    def finish(self) -> None:
        """Send the rows that wait."""
        if not self._rows:
            return
        for entity, line in zip(_LINES, np.array(self._rows).T, strict=True):
            self._file.send(f"series/{entity}", rr.Scalars.columns(scalars=line.copy()), self._moments)
        self._moments, self._rows = Moments(), []
        self._file.flush()

    def state(self) -> dict[str, np.ndarray]:
        """Nothing: what waits is to be sent first."""
        return {}

    def restore(self, state: State) -> None:
        """Nothing to go on from."""


class DistributionTrack(Pictures):
    """Residence time, winding and hop time of all that ended so far; survival, which takes in what is under way.

    `names` are those to show, of `DISTRIBUTIONS`; `drawn` are those that there was something to show of.
    """

    def __init__(
        self, file: RecordingFile, *, names: tuple[str, ...], time_step: float, n_frames: int, scales: Scales | None
    ) -> None:
        super().__init__(n_frames=n_frames)
        self._file, self._names = file, names
        self._time, _ = shown_in("a/U", scales)
        self._pictures: set[str] = set()
        self._ended: list[np.ndarray] = []  # residence times
        self._under_way = np.zeros(0)
        self._histograms = {
            "residence": GrowingHistogram(resolution=time_step, discrete=True),
            "winding": GrowingHistogram(resolution=_WINDING_RESOLUTION, discrete=False),
            "hop_time": GrowingHistogram(resolution=time_step, discrete=True),
        }

    @property
    def drawn(self) -> tuple[str, ...]:
        """The names of what was drawn."""
        return tuple(name for name in self._names if name in self._pictures)

    def count(self, frame: Frame) -> None:
        """Count what ended since the events before."""
        for name, histogram in self._histograms.items():
            histogram.add(getattr(frame, name))
        self._ended.append(frame.residence)
        self._under_way = frame.under_way

    def draw(self, *, step: int, time: float) -> None:
        """Log the distributions as they stand."""
        for name, histogram in self._histograms.items():
            if name in self._names and len(histogram.counts):
                factor = 1.0 if name == "winding" else self._time
                bars = _bars(histogram.counts.copy(), edges=factor * histogram.edges)
                self._log(name, bars, step=step, time=time)
        self._draw_survival(step=step, time=time)

    def state(self) -> dict[str, np.ndarray]:
        """All that was counted."""
        return {
            **super().state(), **state_of(self._histograms),
            "drawn": np.array(sorted(self._pictures), dtype=str), "under_way": self._under_way,
            "ended": np.concatenate([np.zeros(0), *self._ended]),
        }  # fmt: skip

    def restore(self, state: State) -> None:
        """Go on from the `state` of another such recording."""
        super().restore(state)
        restore_parts(self._histograms, state)
        self._pictures = set(state["drawn"].tolist())
        self._under_way, self._ended = state["under_way"].copy(), [state["ended"].copy()]

    def _draw_survival(self, *, step: int, time: float) -> None:
        self._ended = [np.concatenate(self._ended)]
        length = np.concatenate([*self._ended, self._under_way])
        longest = float(length.max(initial=0.0))
        if longest == 0.0:
            return
        curve = survival_curve(length, ended=np.arange(len(length)) < len(self._ended[0]))
        edges = np.linspace(0.0, longest, _SURVIVAL_BARS + 1)
        bars = _bars(curve.at(edges[:-1]), edges=self._time * edges)
        self._log("survival", bars, step=step, time=time)

    def _log(self, name: str, bars: rr.BarChart, *, step: int, time: float) -> None:
        self._pictures.add(name)
        self._file.log_at(f"histograms/{name}", bars, step=step, time=time)


def _bars(values: np.ndarray, *, edges: np.ndarray) -> rr.BarChart:
    # the viewer (0.41) draws a bar from its abscissa on, not around it
    return rr.BarChart(values, abscissa=edges[:-1], widths=np.diff(edges).astype(np.float32), color=BAR_COLOR)
