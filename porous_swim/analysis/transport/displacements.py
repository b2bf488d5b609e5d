"""How displacements over a lag are distributed. Lengths in a, times in a/U."""

from __future__ import annotations

import math

import numpy as np
import pyarrow as pa

from porous_swim.analysis.columns import PLACES, needs
from porous_swim.analysis.histogram import Histogram, histogram
from porous_swim.analysis.transport.lagged import TimeAverages, error_of_mean, even_frames, lag_averages, squared_step
from porous_swim.analysis.transport.transport import Lagged
from porous_swim.results.tables import TableInfo


def msd_exponent(squares: TimeAverages) -> Lagged:
    """Exponent of a mean squared displacement between each lag and the next, at their geometric mean.

    2 where swimmers go straight, 1 where they diffuse, below where they are trapped. Neighbouring lags share
    their way: the error comes from each swimmer's ratio of the two.
    """
    relative = squares.each / squares.value[:, None]
    width = np.diff(np.log(squares.lag))
    return Lagged(
        lag=np.sqrt(squares.lag[1:] * squares.lag[:-1]),
        value=np.diff(np.log(squares.value)) / width,
        standard_error=error_of_mean(np.diff(relative, axis=0)) / width,
        n=squares.n,
    )


@needs(trajectory=PLACES)
def non_gaussian_parameter(trajectory: pa.Table, *, lags: np.ndarray | None = None) -> Lagged:
    """d <r^4>/((d + 2) <r^2>^2) - 1 in d dimensions: 0 for a Gaussian, -2/(d + 2) for equal straight ways.

    The table needs its `TableInfo`. See `lag_averages` for `lags`. Source: Rahman, Phys. Rev. 136, A405 (1964).
    """
    recorded, d = even_frames(trajectory), TableInfo.of(trajectory).dimensions
    square = lag_averages(recorded, squared_step, lags=lags)
    fourth = lag_averages(recorded, lambda *pair: squared_step(*pair) ** 2, lags=lags)
    return non_gaussian(square, fourth, d)


def non_gaussian(square: TimeAverages, fourth: TimeAverages, dimensions: int) -> Lagged:
    """The same from the averages of second and fourth powers of displacements, over the same samples."""
    ratio = dimensions / (dimensions + 2.0) * fourth.value / square.value**2
    influence = fourth.each / fourth.value[:, None] - 2.0 * square.each / square.value[:, None]
    return Lagged(square.lag, ratio - 1.0, ratio * error_of_mean(influence), square.n)


@needs(trajectory=PLACES)
def displacement_histogram(trajectory: pa.Table, *, lag: float, edges: np.ndarray | None = None) -> Histogram:
    """Distribution of one Cartesian component of the displacement over a lag (self part of the van Hove function).

    All components of the plane or space are taken together; `edges` (n_bins + 1,), in a, by default cover
    five root mean squares on either side. The table needs its `TableInfo`.
    """
    recorded, d = even_frames(trajectory), TableInfo.of(trajectory).dimensions
    squares = lag_averages(recorded, squared_step, lags=np.array([lag]))
    n = int(np.rint(lag / (recorded.time[1] - recorded.time[0])))
    steps = (recorded.position[n:] - recorded.position[:-n])[..., :d]  # (n_starts, n_swimmers, d)
    if edges is None:
        edges = np.linspace(-5.0, 5.0, 101) * math.sqrt(float(squares.value[0]) / d)
    swimmer = np.broadcast_to(recorded.swimmer[None, :, None], steps.shape)
    return histogram(steps.ravel(), edges=edges, swimmer=swimmer.ravel())
