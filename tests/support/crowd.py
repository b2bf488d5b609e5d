"""A crowd of swimmers that escape, are captured and turn by exponential clocks: tables, and what is true of them.

Each swimmer is of one of two kinds, by chance, so that the encounters of a swimmer are alike; where both kinds are
one, all encounters are independent. Swimmers start bound, and the run cuts off what is under way at its end.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pyarrow as pa

from tests.support import synthetic

SPACING = 10.0
BOX = (2.0 * SPACING, SPACING, 0.0)  # two colloids, one beside the other
BONDS = np.array([[0, 0], [1, 0], [0, 1], [1, 1], [2, 0]])  # return, two nearest neighbours, second, farther
SPREAD = {"winding": 0.5, "signed_winding": 1.0, "release_pitch": 0.1, "exit_pitch": 0.2}  # within one swimmer


@dataclass(frozen=True)
class Kind:
    """One kind of swimmer."""

    escape: float  # U/a, rate at which its encounters end
    capture: float  # U/a, rate at which its flights end
    passage: float  # U/a, rate at which the escape pitch is passed
    turns: float  # means of winding and, less 1, of signed winding; of release and exit pitch, over 5 and 10
    contact: float  # mean share of an encounter in contact
    bonds: tuple[float, ...]  # probabilities of `BONDS`

    def mean(self, name: str) -> float:
        """Mean of a column that `SPREAD` names."""
        means = {"winding": 1.0, "release_pitch": 0.2, "exit_pitch": 0.1}
        return self.turns - 1.0 if name == "signed_winding" else means[name] * self.turns


@dataclass(frozen=True)
class Crowd:
    """Swimmers of two kinds, equally likely, watched from 0 to `last_time` (a/U)."""

    kinds: tuple[Kind, Kind]
    last_time: float
    n_swimmers: int

    def each(self, name: str) -> np.ndarray:
        """A number of each kind, (2,)."""
        return np.array([getattr(kind, name) for kind in self.kinds])

    def draw(self, rng: np.random.Generator) -> tuple[pa.Table, pa.Table]:
        """Encounters and colloids of one run."""
        n = self.n_swimmers
        about = synthetic.info(n_swimmers=n, last_time=self.last_time, dimensions=2, box=BOX)
        swimmer, start = np.arange(n), np.zeros(n)
        kind_of, place = rng.integers(0, 2, n), np.stack([rng.integers(0, 2, n), np.zeros(n, int)], axis=1)
        rows = []
        while len(swimmer):
            kind = kind_of[swimmer]
            end = start + rng.exponential(1.0 / self.each("escape")[kind])
            again = end + rng.exponential(1.0 / self.each("capture")[kind])
            passage = start + rng.exponential(1.0 / self.each("passage")[kind])
            passage[passage > np.minimum(again, self.last_time)] = np.nan
            rows.append((swimmer, kind, start, end, passage, place))
            chosen = (rng.uniform(size=len(kind))[:, None] > np.cumsum(self.each("bonds"), axis=1)[kind]).sum(axis=1)
            on = again < self.last_time
            swimmer, start, place = swimmer[on], again[on], (place + BONDS[chosen])[on]
        swimmer, kind, start, end, passage, place = (np.concatenate(part) for part in zip(*rows, strict=True))
        cut, end = end > self.last_time, np.minimum(end, self.last_time)
        columns = {
            name: np.array([each.mean(name) for each in self.kinds])[kind] + spread * rng.normal(size=len(kind))
            for name, spread in SPREAD.items()
        }
        columns |= {
            "colloid": place[:, 0] % 2, "image_x": place[:, 0] // 2, "image_y": place[:, 1],
            "contact_time": 2.0 * self.each("contact")[kind] * rng.uniform(size=len(kind)) * (end - start),
            "entry_x": place[:, 0] * SPACING, "exit_x": place[:, 0] * SPACING,
            "entry_y": place[:, 1] * SPACING, "exit_y": place[:, 1] * SPACING,
        }  # fmt: skip
        table = synthetic.encounters(
            about, swimmer=swimmer, start_time=start, end_time=end, end_censored=cut, escape_pitch_time=passage,
            **columns,
        )  # fmt: skip
        return table, synthetic.colloids(about, np.array([[0.0, 0.0, 0.0], [SPACING, 0.0, 0.0]]))

    @cached_property
    def expected(self) -> Expected:
        """What is true of the crowd."""
        return Expected(self)


class Expected:
    """Expectations per swimmer of each kind, (2,), by quadrature over the run and over ages."""

    def __init__(self, crowd: Crowd, *, n_steps: int = 4000) -> None:
        self.kinds, self.time = crowd.kinds, np.linspace(0.0, crowd.last_time, n_steps + 1)
        self.escape, self.capture, self.passage = (
            crowd.each(name)[:, None] for name in ("escape", "capture", "passage")
        )
        both = self.escape + self.capture
        self.is_bound = (self.capture + self.escape * np.exp(-both * self.time)) / both  # (2, n_times) probability
        self.bound, self.free, self.waiting = (
            self.at_risk(state).sum_of(1.0) for state in ("bound", "free", "waiting")
        )
        self.ends, self.moves = self.escape[:, 0] * self.bound, self.capture[:, 0] * self.free
        self.to = self.moves[:, None] * crowd.each("bonds")  # (2, n_bonds)

    def at_risk(self, state: str) -> AtRisk:
        """Stays that are seen to last for an age: begun early enough, and not ended by then."""
        begun = 1.0 + self.capture * _cumulative(1.0 - self.is_bound, self.time)
        rate, still = self.escape, np.ones(1)
        if state == "free":
            rate, begun = self.capture, self.escape * _cumulative(self.is_bound, self.time)
        if state == "waiting":  # for the escape pitch, from capture to capture
            a, b, rate = self.escape, self.capture, self.passage
            still = (b * np.exp(-a * self.time) - a * np.exp(-b * self.time)) / (b - a)
        return AtRisk(self.time, rate, begun[:, ::-1] * still * np.exp(-rate * self.time))

    def of_ends(self, each: np.ndarray) -> float:
        """Mean over completed encounters of what has the mean `each` (2,) with the two kinds."""
        return ratio(self.ends * each, self.ends)


@dataclass(frozen=True, eq=False)
class AtRisk:
    """Stays in a state, by age."""

    age: np.ndarray  # (n_times,)
    rate: np.ndarray  # (2, 1) at which they end
    number: np.ndarray  # (2, n_times) per swimmer

    def sum_of(self, weight: np.ndarray | float) -> np.ndarray:
        """Integral over age of the number times a weight, (2,)."""
        return np.trapezoid(weight * self.number, self.age, axis=1)

    @property
    def mean(self) -> float:
        """Time over ends seen."""
        return ratio(self.sum_of(1.0), self.sum_of(self.rate))

    def mean_completed(self, share: np.ndarray | float = 1.0) -> float:
        """Mean length of those whose end is seen; of a share (2,) of them with each kind."""
        return ratio(share * self.sum_of(self.rate * self.age), share * self.sum_of(self.rate))

    @cached_property
    def survival(self) -> np.ndarray:
        """Limit of Kaplan-Meier curves, (n_times,): the hazard at an age is that of all who reach it."""
        number = self.number[:, :-1]  # nothing has the age of the run, but for what began with it
        hazard = np.sum(self.rate * number, axis=0) / np.sum(number, axis=0)
        return np.exp(-_cumulative(np.append(hazard, hazard[-1])[None], self.age)[0])

    def restricted_mean(self, horizon: float) -> float:
        """Area under the curve up to an age of the grid."""
        within = self.age <= horizon * (1.0 + 1e-12)
        return float(np.trapezoid(self.survival[within], self.age[within]))


def ratio(numerator: np.ndarray, denominator: np.ndarray) -> float:
    """What a ratio of sums over swimmers tends to, from expectations of the two kinds, (2,) each."""
    return float(np.sum(numerator) / np.sum(denominator))


def _cumulative(values: np.ndarray, time: np.ndarray) -> np.ndarray:
    """Integral from 0 to each time, of (k, n_times)."""
    means = 0.5 * (values[:, 1:] + values[:, :-1]) * np.diff(time)
    return np.concatenate([np.zeros((len(values), 1)), np.cumsum(means, axis=1)], axis=1)
