"""Scans as one batch: each scene comes out as if it had run alone."""

from __future__ import annotations

import numpy as np
import pytest

import porous_swim as ps
from porous_swim.running.batch import run_batch
from tests.validation.scenes import one_swimmer


def scan() -> list[ps.Scene]:
    """Swimmers of several strengths, at colloids of several radii, on several ways; all met and left or held."""
    base = one_swimmer(20.0, 0.8, [-40.0, 0.1], time_step=0.1, duration=60.0, integrator="located")
    base = base.replace({"record": {"every": 10.0, "swimmers": 2}})
    changes = [{}, {"obstacles.radius": 5.0}, {"swimmers.dipole_strength": 0.4}, {"swimmers.dipole_strength": -0.8},
               {"obstacles.radius": 2000.0, "swimmers.release.position": [-2010.0, 30.0]}]  # fmt: skip
    return [base.replace(change) for change in changes]


def test_each_scene_of_a_batch_is_the_scene_run_alone():
    scenes = scan()
    for member, scene in zip(run_batch(scenes), scenes, strict=True):
        alone = ps.run(scene)
        tracks = ps.analysis.tracks(alone.trajectory)
        # centres of the batch stand up to 1e4 apart: 2e-12 of rounding, and 1e-12 per step of the integrator
        assert member.position == pytest.approx(tracks.position, rel=0, abs=1e-8)
        assert member.director == pytest.approx(tracks.director, rel=0, abs=1e-9)
        assert len(member.encounters["swimmer"]) == alone.encounters.num_rows
        for name in alone.encounters.column_names:
            expected = alone.encounters[name].to_numpy(zero_copy_only=False).astype(float)
            assert member.encounters[name].astype(float) == pytest.approx(expected, rel=1e-7, abs=1e-7, nan_ok=True), (
                name
            )


def test_noise_of_one_member_is_not_that_of_another():
    scene = one_swimmer(20.0, 0.8, [-22.0, 0.1], time_step=0.01, duration=1.0)
    noisy = scene.replace(
        {
            "noise": {"kind": "brownian", "translational_diffusion": 0.01},
            "run.integrator": "euler",
            "run.precision": "f32",
        }
    )
    first, second = run_batch([noisy, noisy])
    assert not np.allclose(first.position[-1], second.position[-1], atol=1e-4)


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (
            {"run.duration": 30.0, "record.every": 10.0},
            "run.duration: scenes of a batch share it, found 30.0 beside 60.0",
        ),
        (
            {"hydrodynamics": {"kind": "none"}},
            "hydrodynamics: scenes of a batch share it, found none beside image_dipole",
        ),
        (
            {"obstacles": {"layout": "square", "radius": 3.0, "spacing": 9.0, "cells": [2, 2]}},
            "obstacles.layout: a batch is of scenes with layout single",
        ),
    ],
)
def test_scenes_that_differ_in_structure_are_refused_in_one_sentence(change, sentence):
    first = scan()[0]
    release = {"swimmers.release": {"kind": "uniform"}} if "obstacles" in change else {}
    with pytest.raises(ps.SceneError, match=sentence):
        run_batch([first, first.replace({**change, **release})])
