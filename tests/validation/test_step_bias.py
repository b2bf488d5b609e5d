"""What a step four times shorter changes in the hexagonal crystal, and what it must not change.

A walk that is put back on the wall at the end of each step stays, in law, 0.5826 sqrt(2 D dt) closer to the wall than
reflected diffusion (Asmussen, Glynn and Pitman, Ann. Appl. Probab. 5, 875, 1995). So residence times are too long by
a term in sqrt(dt), whose difference between two steps the independent simulator gives. Rates during an
encounter vary at most as the flow does, as height^-3: by 3 x 0.5826 [sqrt(2 D dt) - sqrt(2 D dt/4)], 0.7 % here.
(Turns summed without sign gain 49 % between these steps in the independent runs, steps that touch the wall lose 41 %.)
"""

from __future__ import annotations

import math

import numpy as np

import porous_swim as ps
from porous_swim.analysis.columns import column
from porous_swim.analysis.estimates import Swimmers, ratio_of_sums
from tests.validation.agreement import Figure, figure, reference, require_agreement, sizes
from tests.validation.scenes import LATTICES, crystal

STEPS = (0.005, 0.00125)
LISTED = [reference("crystals.json")["hexagonal_alpha4"]["dt"][f"{time_step:g}"] for time_step in STEPS]
D = LATTICES["hexagonal_alpha4"]["D"]


def per_encounter(results: ps.Results) -> dict[str, Figure]:
    """What one encounter brings: time, time in contact (both per end seen), and turns of completed ones."""
    encounters = results.encounters
    swimmers = Swimmers.of(column(encounters, "swimmer"))
    ends = swimmers.sums(~column(encounters, "end_censored"))
    residence = ps.analysis.residence_times(encounters)
    return {
        "residence": Figure(residence.mean, residence.standard_error),
        "contact time": Figure(*ratio_of_sums(swimmers.sums(column(encounters, "contact_time")), ends)),
        "turns": figure(ps.analysis.winding(encounters).completed),
    }


def per_time(results: ps.Results) -> dict[str, Figure]:
    """Turns per time in encounters, and the displacement by the wall per time in contact."""
    encounters = results.encounters
    swimmers = Swimmers.of(column(encounters, "swimmer"))
    push, contact = (swimmers.sums(column(encounters, name)) for name in ("wall_push", "contact_time"))
    return {
        "turns per time": figure(ps.analysis.winding(encounters).rate),
        "wall push per time in contact": Figure(*ratio_of_sums(push, contact)),
    }


def listed_difference(name: str) -> Figure:
    """The change of a listed figure from the long to the short step."""
    long, short = (Figure(*listed[name]) for listed in LISTED)
    return long - short


@sizes(1000, 8000)
def test_a_shorter_step_changes_encounters_by_the_known_bias_and_rates_not_at_all(count):
    long, short = (ps.run(crystal("hexagonal_alpha4", count, time_step=time_step, seed=2)) for time_step in STEPS)
    bias = listed_difference("residence_time_censored")
    # Longer encounters are longer in contact: what they spend on the way out does not depend on the wall's shift.
    known = {"residence": bias, "contact time": bias, "turns": listed_difference("net_winding")}
    before, after = per_encounter(long), per_encounter(short)
    require_agreement({name: before[name] - after[name] for name in known}, known)

    shift = 0.5826 * (math.sqrt(2.0 * D * STEPS[0]) - math.sqrt(2.0 * D * STEPS[1]))
    require_agreement(per_time(long), per_time(short), bias=3.0 * shift)
    # The swimmer goes one way round: turns along the director are the turns about z, but for its rare reversals.
    along, about = (column(long.encounters, name) for name in ("winding", "signed_winding"))
    assert np.sum(along) > 0.99 * np.sum(np.abs(about))
