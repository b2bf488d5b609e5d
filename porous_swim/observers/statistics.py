"""What is counted, in a recording: lines over time and histograms that grow."""

from __future__ import annotations

import numpy as np
import rerun as rr

from porous_swim.observers.base import BOUND, CONTACT, FREE, Frame
from porous_swim.observers.histogram import GrowingHistogram
from porous_swim.observers.palette import HOP_COLOR, MSD_COLOR, RETURN_COLOR, STATE_COLORS
from porous_swim.observers.stream import RecordingFile

_BATCH_ROWS = 256  # a row on its own costs a kilobyte
_MAX_PICTURES = 100  # of each histogram over a run: it is seen to grow, for some 100 kB
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

    def __init__(self, file: RecordingFile) -> None:
        self._file = file
        self._start: np.ndarray | None = None  # (n_swimmers, 3)
        self._rows: list[tuple[int, float, tuple[float, ...]]] = []
        for entity, (label, color) in _LINES.items():
            file.log(f"series/{entity}", rr.SeriesLines(colors=[color], names=[label], widths=[2.0]))

    def observe(self, frame: Frame) -> None:
        """Take in one frame."""
        if self._start is None:
            self._start = frame.position.copy()
        fractions = np.bincount(frame.state, minlength=3) / max(len(frame.state), 1)
        n_swimmers = max(len(frame.state), 1)
        squared = np.sum((frame.position - self._start) ** 2, axis=1)
        values = (
            float(fractions[FREE]),
            float(fractions[BOUND]),
            float(fractions[CONTACT]),
            frame.counts.n_hops / n_swimmers,
            frame.counts.n_returns / n_swimmers,
            float(squared.mean()) if len(squared) else 0.0,
        )
        self._rows.append((frame.step, frame.time, values))
        if len(self._rows) >= _BATCH_ROWS:
            self.send()

    def send(self) -> None:
        """Send the rows that wait."""
        if not self._rows:
            return
        steps, times, values = (list(column) for column in zip(*self._rows, strict=True))
        for entity, line in zip(_LINES, np.array(values).T, strict=True):
            self._file.send(f"series/{entity}", rr.Scalars.columns(scalars=line.copy()), steps=steps, times=times)
        self._rows = []
        self._file.flush()


class HistogramTrack:
    """Residence time, winding and hop time of all that ended so far."""

    def __init__(self, file: RecordingFile, *, time_step: float, n_frames: int) -> None:
        self._file = file
        self._every = max(1, n_frames // _MAX_PICTURES)
        self._n_seen = 0
        self.histograms = {
            "residence": GrowingHistogram(resolution=time_step, discrete=True),
            "winding": GrowingHistogram(resolution=_WINDING_RESOLUTION, discrete=False),
            "hop_time": GrowingHistogram(resolution=time_step, discrete=True),
        }

    def observe(self, frame: Frame) -> None:
        """Count what ended since the frame before; now and then draw."""
        for name, histogram in self.histograms.items():
            histogram.add(getattr(frame, name))
        if self._n_seen % self._every == 0:
            self.draw(step=frame.step, time=frame.time)
        self._n_seen += 1

    def draw(self, *, step: int, time: float) -> None:
        """Log the histograms as they stand."""
        colors = {"residence": STATE_COLORS[CONTACT], "winding": STATE_COLORS[BOUND], "hop_time": HOP_COLOR}
        for name, histogram in self.histograms.items():
            if not len(histogram.counts):
                continue
            edges = histogram.edges
            bars = rr.BarChart(
                histogram.counts.copy(),
                abscissa=0.5 * (edges[1:] + edges[:-1]),
                widths=np.diff(edges).astype(np.float32),
                color=colors[name],
            )
            self._file.log_at(f"histograms/{name}", bars, step=step, time=time)
