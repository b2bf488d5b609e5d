"""Each statistic of encounters, and what it is of a crowd."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import pyarrow as pa
from scipy.stats import foldnorm, norm

import porous_swim as ps
from porous_swim.analysis.columns import column
from porous_swim.analysis.lifetimes.survival import WaitingTimes
from tests.support.coverage import Statistic
from tests.support.crowd import SPACING, SPREAD, AtRisk, Crowd, ratio

an = ps.analysis
HORIZON = 8.0  # a/U, of restricted means


def waiting(found: WaitingTimes) -> list:
    return [found.estimate(), found.restricted_estimate(), found.completed_estimate()]


def waiting_truth(true: AtRisk) -> list[float]:
    return [true.mean, true.restricted_mean(HORIZON), true.mean_completed()]


def profile(encounters: pa.Table, edges: Iterable[float]) -> tuple:
    names = ("exit_pitch", "winding", "swimmer")
    pitch, turns, swimmer = (column(encounters, name) for name in names)
    found = an.binned_mean(pitch, against=turns, edges=np.array(edges), swimmer=swimmer)
    return found.mean, found.standard_error


def links(network: pa.Table, n: int) -> tuple:
    """Shares of `n` links in their order; nothing where one was not used."""
    shares = column(network, "probability"), column(network, "standard_error")
    return shares if len(network) == n else (np.full(n, np.nan),) * 2


def of_encounters(crowd: Crowd) -> dict[str, Statistic]:
    """Each statistic of encounters, found in `(encounters, colloids)`."""
    true, kinds = crowd.expected, crowd.kinds
    turns, contact = crowd.each("turns"), crowd.each("contact")

    def mean(name: str) -> np.ndarray:
        return np.array([kind.mean(name) for kind in kinds])

    def above(name: str, edge: float) -> np.ndarray:
        return norm.sf(edge, mean(name), SPREAD[name])

    net = np.abs(mean("signed_winding"))
    around = above("winding", 0.5) - above("winding", 1.5)
    every = 1.0 + true.moves  # censored ones too
    x, y, xy, xx = true.to[:, 1:].sum(axis=0) / true.to[:, 1:].sum()  # shares of the bonds
    hops = true.to[:, 1:].sum(axis=1)
    length = SPACING * (x + y + np.sqrt(2.0) * xy + 2.0 * xx)
    return {
        "residence_times": Statistic(
            lambda d: waiting(an.residence_times(d[0], horizon=HORIZON)), waiting_truth(true.at_risk("bound"))),
        "flights": Statistic(
            lambda d: waiting(an.flights(d[0], horizon=HORIZON)), waiting_truth(true.at_risk("free"))),
        "escape_pitch_times": Statistic(
            lambda d: waiting(an.escape_pitch_times(d[0], horizon=HORIZON)), waiting_truth(true.at_risk("waiting"))),
        "fit_lifetimes": Statistic(
            lambda d: an.fit_lifetimes(an.residence_lifetimes(d[0]), "exponential").parameters.values(),
            [true.at_risk("bound").mean]),
        "survival_at": Statistic(
            lambda d: an.survival_at(an.residence_lifetimes(d[0]), np.array([2.0, 12.0])),
            np.interp([2.0, 12.0], true.time, true.at_risk("bound").survival)),
        "winding": Statistic(
            lambda d: vars(an.winding(d[0])).values(),
            [true.of_ends(turns), true.of_ends(foldnorm.mean(net)), ratio((1.0 + true.moves) * turns, true.bound),
             true.of_ends(above("winding", 1.0))]),
        "orbits": Statistic(
            lambda d: list(vars(an.orbits(d[0])).values())[2:],
            [true.of_ends(above("winding", 1.0)),
             true.of_ends(above("signed_winding", 1.0) + 1.0 - above("signed_winding", -1.0)),
             true.of_ends(above("signed_winding", 0.0))]),
        "histogram": Statistic(
            lambda d: an.orbits(d[0], edges=np.array([0.5, 1.5])).winding, [true.of_ends(around)]),
        "binned_mean": Statistic(
            lambda d: profile(d[0], [0.5, 1.5]),
            [ratio(every * around * mean("exit_pitch"), every * around)]),
        "departures": Statistic(
            lambda d: [an.departures(d[0]).release, an.departures(d[0]).exit],
            [true.of_ends(mean("release_pitch")), true.of_ends(mean("exit_pitch"))]),
        "fractions": Statistic(
            lambda d: [an.bound_fraction(d[0]), an.contact_fraction(d[0]), an.contact_fraction_of_encounters(d[0])],
            [np.mean(true.bound) / crowd.last_time, np.mean(contact * true.bound) / crowd.last_time,
             ratio(contact * true.bound, true.bound)]),
        "bound_fraction_at": Statistic(
            lambda d: an.bound_fraction_at(d[0], np.array([0.5, 1.0]) * crowd.last_time),
            true.is_bound.mean(axis=0)[[len(true.time) // 2, -1]]),
        "hop_statistics": Statistic(
            lambda d: vars(an.hop_statistics(*d)).values(),
            [np.mean(hops) / crowd.last_time, np.mean(true.to[:, 0]) / crowd.last_time,
             true.at_risk("free").mean_completed(hops / true.moves), length, length, x + y]),
        "hop_shells": Statistic(lambda d: vars(an.hop_shells(an.hop_table(*d))).values(), [x + y, xy, xx]),
        "hop_network": Statistic(
            lambda d: links(an.hop_network(an.hop_table(*d)), 8), [y, xx, x, xy, x, xy, y, xx]),
        "hop_counts": Statistic(
            lambda d: links(an.hop_counts(an.hop_table(*d)), 4), [y + xx, x + xy, x + xy, y + xx]),
    }  # fmt: skip
