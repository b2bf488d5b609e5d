"""Passive swimmers among impenetrable discs: their effective diffusivity against the solution of the cell problem.

D_eff/D = sigma/(1 - f), sigma the conductivity of the medium around insulating discs and f the share of the contact
discs. The values are those of multipole expansions of the cell problem, with residuals below 1e-4; the square array
agrees with Perrins, McKenzie and McPhedran, Proc. R. Soc. A 369, 207 (1979) to six digits.
"""

from __future__ import annotations

import math

import pytest

import porous_swim as ps

CONTACT = 4.5  # radius of the discs that centres cannot enter, a
D, D_R = 10.0, 25.0  # swimming adds 1/(2 D_r), 0.2 % of D: what colloids make of it is another 0.1 % of that


@pytest.mark.parametrize(
    ("layout", "share", "ratio", "count"),
    [
        ("square", 0.4, 0.708919, 2000),
        pytest.param("square", 0.2, 0.833163, 8000, marks=pytest.mark.slow),
        pytest.param("hexagonal", 0.2, 0.833332, 8000, marks=pytest.mark.slow),
        pytest.param("hexagonal", 0.4, 0.714075, 8000, marks=pytest.mark.slow),
    ],
)
def test_passive_swimmers_in_a_lattice_have_its_effective_diffusivity(
    layout: str, share: float, ratio: float, count: int
) -> None:
    cell = math.pi * CONTACT**2 / share  # area of a disc
    spacing, rows = (math.sqrt(cell), 4) if layout == "square" else (math.sqrt(2.0 * cell / math.sqrt(3.0)), 2)
    results = ps.run(
        ps.Scene.from_mapping(
            {
                "swimmers": {"count": count, "dipole_strength": 0.0},
                "hydrodynamics": {"kind": "none"},
                "obstacles": {
                    "layout": layout, "radius": CONTACT - 1.0, "spacing": spacing, "cells": [4, rows],
                },
                "domain": {"dimensions": 2},
                "noise": {"kind": "brownian", "translational_diffusion": D, "rotational_diffusion": D_R},
                "run": {"time_step": 0.002, "duration": 40.0, "seed": 1, "device": "cpu"},
                "record": {"every": 0.2, "swimmers": 0, "trails": 0},
            }
        )
    )  # fmt: skip
    found = ps.analysis.ensemble_diffusivity(results.lags)
    assert found.linear
    assert abs(found.value - ratio * (D + 0.5 / D_R)) < 4.0 * found.standard_error
    assert found.standard_error < 0.03 * found.value
    assert results.summary["diffusivity"]["effective"] == found.estimate().as_dict()
