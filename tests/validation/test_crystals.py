"""Statistics of swimmers in two crystals, against an independent simulator of the same scheme and step.

There the lattice is infinite, here periodic, and contact with another colloid ended an encounter, which never
happened in 8000 swimmers' runs: the definitions agree. The net winding of the independent runs in space is a
different quantity from ours and is left out.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import binomtest

import porous_swim as ps
from porous_swim.analysis.columns import column
from tests.validation.agreement import Figure, figure, rate, reference, require_agreement, share, sizes
from tests.validation.scenes import crystal

TIME_STEP = 0.005
DURATION = 300.0
CRYSTALS = reference("crystals.json")
# of the hexagonal crystal: continuous-path contact and escape at a step of 0.0025, by the same simulator
LIMIT = Figure(35.27, 0.15)


def measured(results: ps.Results, count: int) -> dict[str, Figure]:
    """The figures of a run, under the names of the reference file."""
    encounters, last = results.encounters, ps.analysis.residence_times(results.encounters, horizon=250.0)
    hop = ps.analysis.hop_statistics(encounters, results.colloids)
    every, ended = np.ones(len(encounters), bool), ~column(encounters, "end_censored")
    per_time = {"count": count, "duration": DURATION}
    found = {
        "residence_time_censored": Figure(last.mean, last.standard_error),
        "residence_time_kaplan_meier_restricted_250": Figure(last.restricted_mean, last.restricted_standard_error),
        "encounters_per_swimmer_time": rate(encounters, every, **per_time),
        "escapes_per_swimmer_time": rate(encounters, ended, **per_time),
        "hops_per_swimmer_time": figure(hop.hop_rate),
        "mean_hop_time": figure(hop.time),
        "hops_to_nearest_neighbours": figure(hop.nearest_share),
    }
    net = ps.analysis.winding(encounters).net
    if net.n > 0:  # in the plane
        found["net_winding"] = figure(net)
    for row in results.timeseries.to_pylist():
        found[f"fraction_bound_at {row['time']}"] = share(row["fraction_bound"], count)
        found[f"msd_at {row['time']}"] = Figure(row["msd"], row["msd_standard_error"])
    return found


def expected(listed) -> dict[str, Figure]:
    """The listed figures, flat."""
    flat = {name: value for name, value in listed.items() if isinstance(value, list)}
    for name in ("fraction_bound_at", "msd_at"):
        flat |= {f"{name} {time}": value for time, value in listed[name].items()}
    return {name: Figure(*value) for name, value in flat.items()}


@sizes(1000, 8000)
@pytest.mark.parametrize("case", ["hexagonal_alpha4", "fcc_3d"])
def test_statistics_of_a_crystal_are_those_of_an_independent_simulator(case, count):
    listed = CRYSTALS[case]["dt"][f"{TIME_STEP:g}"]
    results = ps.run(crystal(case, count, time_step=TIME_STEP, seed=1))
    theirs, ours = expected(listed), measured(results, count)
    require_agreement({name: ours[name] for name in theirs}, theirs)
    # Returns are few, and counts of independent rare events: given their sum they are binomial.
    n_returns = len(ps.analysis.returns(results.encounters))
    print(f"returns: {n_returns} of {count} swimmers against {listed['n_returns']} of {listed['n_swimmers']}")
    if n_returns + listed["n_returns"] > 0:
        odds = count / (count + listed["n_swimmers"])
        assert binomtest(n_returns, n_returns + listed["n_returns"], odds).pvalue > 6.3e-5  # 4 standard errors


@sizes(2000, 8000)
def test_reflecting_walls_give_the_residence_time_of_short_steps_at_a_step_of_0_02(count):
    scene = crystal("hexagonal_alpha4", count, time_step=0.02, seed=1, integrator="reflected")
    last = ps.analysis.residence_times(ps.run(scene).encounters)
    # in docs/convergence.md steps of 0.02 and 0.005 differ by 0.1 % (0.4)
    require_agreement({"residence": Figure(last.mean, last.standard_error)}, {"residence": LIMIT}, bias=0.005)
