"""Every kernel that a scene may ask for compiles and makes ten steps: a pairwise cover here, all of them on demand.

`python -m pytest -m slow tests/engine/test_combinations.py` runs all 810: more than an hour
on two cores where nothing is cached.
"""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from itertools import combinations, product

import pytest

import porous_swim as ps
from tests.support import combinations as kernels
from tests.support.combinations import CHOICES, Combination, name_of
from tests.support.commands import ROOT, environment

WORKERS = 2  # processes, one thread each
TO_A_PROCESS = 12  # combinations: its start is a fifth of a compilation
LONGEST = 300.0  # s, for one combination on a busy machine; it takes some 10 s


def outcomes(wanted: Sequence[Combination]) -> Iterator[tuple[str, str]]:
    """The name of each combination, and what is wrong with it; a process that dies costs the one that it was at."""
    rest = list(wanted)
    while rest:
        try:
            child = subprocess.run(
                [sys.executable, "-m", "tests.support.combinations"], cwd=ROOT, env=environment(),
                input=json.dumps(rest), capture_output=True, text=True, timeout=LONGEST * len(rest),
            )  # fmt: skip
            printed, end = child.stdout, f"ended with status {child.returncode}: {child.stderr.strip()[-200:]}"
        except subprocess.TimeoutExpired as error:
            printed, end = (error.stdout or b"").decode(), f"took more than {error.timeout:g} s"
        said = [json.loads(line) for line in printed.splitlines() if line.startswith("{")]
        ends = [line for line in said if "name" in line]
        yield from ((line["name"], line["wrong"]) for line in ends)
        rest = rest[len(ends) :]
        if rest:
            yield name_of(rest[0]), f"the process {end}"
            rest = rest[1:]


def failures(wanted: Sequence[Combination]) -> dict[str, str]:
    """What is wrong, by the name of the combination; each must have run."""
    parts = [wanted[first : first + TO_A_PROCESS] for first in range(0, len(wanted), TO_A_PROCESS)]
    with ThreadPoolExecutor(WORKERS) as pool:
        found = dict(pair for part in pool.map(lambda part: list(outcomes(part)), parts) for pair in part)
    assert set(found) == {name_of(combination) for combination in wanted}
    return {name: wrong for name, wrong in found.items() if wrong}


def test_a_scene_admits_what_the_reference_says():
    # hydrodynamics, shape, surface and dimensions: 54; euler: 3 noises, 2 precisions; reflected: 2, 2, and flights
    # or none; located: without noise in f64
    assert len(kernels.admitted()) == 54 * (3 * 2 + 2 * 2 * 2 + 1)
    for combination in kernels.everything():
        try:
            kernels.scene_of(combination)
            allowed = True
        except ps.SceneError:
            allowed = False
        assert allowed == kernels.is_admitted(combination), name_of(combination)


def test_the_cover_holds_every_pair_of_choices_that_is_admitted():
    # counted without the generator: a pair is admitted where some combination that is admitted has both
    admitted, cover = kernels.admitted(), kernels.cover(kernels.admitted())
    n_pairs = 0
    for first, second in combinations(CHOICES, 2):
        for choices in product(CHOICES[first], CHOICES[second]):
            held = [any((c[first], c[second]) == choices for c in group) for group in (admitted, cover)]
            assert held[0] == held[1], choices
            n_pairs += held[0]
    assert n_pairs > 150
    assert len(cover) <= 16


def test_a_process_that_dies_is_a_failure_that_names_its_combination(monkeypatch):
    good = {"hydrodynamics": "none", "integrator": "euler", "noise": "none", "shape": "sphere", "surface": "none",
            "dimensions": "2-D", "precision": "f64", "flights": "steps"}  # fmt: skip
    bad = good | {"surface": "abort"}
    found = dict(outcomes([bad, good]))
    assert found[name_of(good)] == ""
    assert "status" in found[name_of(bad)]


def test_every_pair_of_parts_compiles_and_makes_ten_steps():
    assert failures(kernels.cover(kernels.admitted())) == {}


@pytest.mark.slow
def test_all_parts_compile_together_and_make_ten_steps():
    assert failures(kernels.admitted()) == {}
