"""Displacements of all swimmers, summed on the device: against their trajectories, and against exact walks."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import porous_swim as ps
from porous_swim.analysis.transport.diffusive_window import Memory, choose
from porous_swim.analysis.transport.transport import tracks
from porous_swim.engine.windows import OPEN, spacings
from porous_swim.observers.lags import Lags
from porous_swim.results.tables import LAGS_SCHEMA, TableInfo, make_table
from tests.support import synthetic
from tests.support.commands import SMALL

an = ps.analysis
FREE = """
name: free
swimmers: {count: 4000, dipole_strength: 0.0, release: {kind: uniform}}
hydrodynamics: {kind: none}
noise: {kind: brownian, translational_diffusion: 0.05, rotational_diffusion: 0.3}
obstacles: {layout: none}
domain: {dimensions: 3, boundary: periodic, size: [50, 50, 50]}
run: {time_step: 0.05, duration: 32, seed: 3, device: cpu}
record: {every: 0.5, swimmers: 0, trails: 0}
"""


def scene_of(folder: Path, text: str, **changes: object) -> ps.Scene:
    (folder / "scene.yaml").write_text(text)
    return ps.load_scene(folder / "scene.yaml").replace(changes)


def lags_of(simulation: ps.Simulation) -> Lags:
    scene = simulation.scene
    return Lags(simulation.survey.group_sizes, period=scene.record_period)


def columns(table) -> dict[str, np.ndarray]:
    return {name: table[name].to_numpy() for name in table.schema.names}


@pytest.mark.parametrize("precision", ["f32", "f64"])
@pytest.mark.parametrize("dimensions", [2, 3])
def test_sums_over_lags_are_those_of_the_trajectories_of_all_swimmers(tmp_path, dimensions, precision):
    changes = {"run.duration": 20.0, "run.precision": precision, "record.every": 0.25, "record.trails": 0}
    if dimensions == 3:
        changes |= {"obstacles": {"layout": "fcc", "radius": 3.5, "spacing": 10.0, "cells": [2, 2, 2]}}
        changes |= {"domain": {"dimensions": 3, "boundary": "periodic"}}
    scene = scene_of(tmp_path, SMALL)
    count = scene.swimmers.count
    results = ps.run(scene.replace({**changes, "record.swimmers": count}))
    every = tracks(results.trajectory)
    expected = columns(synthetic.lags(results.info, every.time, every.position, every.director))
    found = columns(results.lags)
    size = found["n_swimmers"].max()
    assert found["n_swimmers"].sum() == count * len(np.unique(found["lag"]))
    for name in ("msd", "fourth_moment", "director_correlation"):
        each = expected[name].reshape(-1, count)
        means = [np.mean(each[:, i : i + size], axis=1) for i in range(0, count, size)]
        # single precision: a sum of 40 lengths of up to 40, each rounded to 2^-24 of it
        tolerance = {"f32": 2e-5, "f64": 1e-12}[precision]
        np.testing.assert_allclose(
            found[name].reshape(len(each), -1), np.transpose(means), rtol=tolerance, atol=tolerance
        )
    np.testing.assert_array_equal(np.unique(found["lag"]), np.unique(expected["lag"]))
    windows = expected["n_windows"].reshape(-1, count)[:, 0]
    np.testing.assert_array_equal(found["n_windows"].reshape(len(windows), -1)[:, 0], windows)


CAGES = """
name: cages
swimmers: {count: 500, dipole_strength: 0.0}
hydrodynamics: {kind: none}
noise: {kind: brownian, translational_diffusion: 0.1, rotational_diffusion: 0.5}
obstacles: {layout: square, radius: 5, spacing: 10.5, cells: [10, 10]}
domain: {dimensions: 2}
run: {time_step: 0.02, duration: 96, seed: 1}
record: {every: 0.5, swimmers: 500, trails: 0}
"""


def off_all_starts(results, *, burn_in: int = 0) -> np.ndarray:
    """Mean squared displacement at each lag, less that from all starts, over the error of the difference."""
    position, squares = tracks(results.trajectory).position[burn_in:], an.ensemble_msd(results.lags)
    off = []
    for lag, each in zip(squares.lag, squares.each, strict=True):
        k = round(lag / 0.5)
        difference = each - np.mean(np.sum((position[k:] - position[:-k]) ** 2, axis=2), axis=0)  # a swimmer each
        off.append(np.mean(difference) / (np.std(difference, ddof=1) / np.sqrt(len(difference)) + 1e-5))
    return np.array(off)


def test_the_release_has_the_same_weight_at_every_lag(tmp_path):
    # Swimmers released all over closed cells gather in their corners: the way from there is shorter than between two
    # later moments. The longest lag, of two windows of which one began at the release, was once five errors off.
    results = ps.run(scene_of(tmp_path, CAGES))
    assert len(an.ensemble_msd(results.lags).lag) == 22
    assert np.max(np.abs(off_all_starts(results))) < 4.0  # standard errors


def test_lags_begin_after_the_burn_in(tmp_path):
    results = ps.run(scene_of(tmp_path, CAGES, **{"record.burn_in": 30.2}))  # the first frame after it is that at 30.5
    squares = an.ensemble_msd(results.lags)
    assert squares.lag[-1] == 32.0  # of 131 frames after it half is 65.5
    assert np.max(np.abs(off_all_starts(results, burn_in=61))) < 4.0
    short = an.time_averaged_msd(results.trajectory, lags=np.array([0.5]))
    position = tracks(results.trajectory).position[61:]
    np.testing.assert_allclose(short.value, np.mean(np.sum((position[1:] - position[:-1]) ** 2, axis=2)), rtol=1e-12)
    np.testing.assert_allclose(squares.value[0], short.value[0], rtol=1e-5)


@pytest.mark.parametrize("n_frames", [40, 64, 100, 192, 200, 400, 1000, 2560])
def test_windows_of_every_lag_begin_all_through_the_run_that_has_room_for_them(n_frames):
    for spacing in spacings(n_frames):
        for lag in spacing.lags:
            every = np.arange(n_frames + 1)
            begin = [f for f in every if any(spacing.begins(f, q) for q in range(OPEN)) and f + lag <= n_frames]
            assert len(begin) >= OPEN
            # each stands for the frames half the way to the next on either side
            assert begin[0] <= 0.5 * spacing.frames
            assert n_frames - lag - begin[-1] < spacing.frames
            assert abs(np.mean(begin) - 0.5 * (n_frames - lag)) <= 0.5 * spacing.frames


def test_an_interrupted_run_has_lags_up_to_half_of_what_was_seen(tmp_path):
    simulation = ps.Simulation(scene_of(tmp_path, FREE, **{"swimmers.count": 50}))
    lags = lags_of(simulation)
    for _ in range(40):  # of 64 frames
        simulation.advance(simulation.scene.record_period)
        lags.observe(simulation.frame())
    assert lags.columns()["lag"].max() == 20


def test_time_series_are_those_of_the_trajectories_of_all_swimmers(tmp_path):
    scene = scene_of(tmp_path, SMALL, **{"run.duration": 10.0})
    results = ps.run(scene.replace({"record.swimmers": scene.swimmers.count}))
    every, series = tracks(results.trajectory), columns(results.timeseries)
    state = results.trajectory["state"].to_numpy().reshape(len(every.time), -1)
    np.testing.assert_array_equal(series["fraction_bound"], np.mean(state > 0, axis=1))
    np.testing.assert_array_equal(series["fraction_contact"], np.mean(state == 2, axis=1))
    squared = np.sum((every.position - every.position[0]) ** 2, axis=2)
    error = np.std(squared, axis=1, ddof=1) / np.sqrt(squared.shape[1])
    np.testing.assert_allclose(series["msd"], squared.mean(axis=1), rtol=1e-5, atol=1e-6)
    np.testing.assert_allclose(series["msd_standard_error"], error, rtol=1e-4, atol=1e-6)


def test_persistent_walkers_have_the_displacements_directors_and_diffusivity_of_theory(tmp_path):
    results = ps.run(scene_of(tmp_path, FREE))
    squares, overlap = an.ensemble_msd(results.lags), an.ensemble_director_correlation(results.lags)
    decay, t = 2.0 * 0.3, squares.lag
    expected = 6.0 * 0.05 * t + 2.0 / decay**2 * (decay * t - 1.0 + np.exp(-decay * t))
    # 4 standard errors; the reflected scheme is of second order: 0.05^2 of a decay of 0.6 is far below them
    assert np.all(np.abs(squares.value - expected) < 4.0 * squares.standard_error + 1e-3 * expected)
    assert np.all(np.abs(overlap.value - np.exp(-decay * t)) < 4.0 * overlap.standard_error + 1e-3)
    fit = an.ensemble_diffusivity(results.lags, window=(8.0, 16.0))
    assert 3900 < fit.n <= 4000  # a last group of fewer is left out
    assert abs(fit.value - (0.05 + 1.0 / (3.0 * decay))) < 4.0 * fit.standard_error
    assert fit.linear


def test_brownian_displacements_are_gaussian(tmp_path):
    text = FREE.replace("rotational_diffusion: 0.3", "rotational_diffusion: 1000.0").replace("0.05, r", "1.0, r")
    results = ps.run(scene_of(tmp_path, text, **{"run.duration": 8.0}))
    found = an.ensemble_non_gaussian_parameter(results.lags)
    assert np.all(np.abs(found.value) < 4.0 * found.standard_error + 1e-3)


def test_sums_do_not_depend_on_threads_or_on_what_is_recorded(tmp_path):
    scene = scene_of(tmp_path, SMALL, **{"run.duration": 5.0})
    plain = ps.run(scene.replace({"run.threads": 1}))
    other = ps.run(scene.replace({"run.threads": 2, "record.swimmers": 0, "record.trails": 0}))
    for table in ("lags", "timeseries"):
        assert getattr(plain, table).equals(getattr(other, table), check_metadata=False)
    assert TableInfo.of(plain.lags).n_swimmers == scene.swimmers.count


def test_a_frame_that_is_left_out_spoils_no_lag(tmp_path):
    scene = scene_of(tmp_path, FREE, **{"swimmers.count": 50, "noise": {"kind": "none"}, "run.duration": 16.0})
    simulation = ps.Simulation(scene)
    lags = lags_of(simulation)
    for n in (1, 1, 1, 2, 1, 1, 3, 1, 1, 1, 4):  # frames to the next look
        simulation.advance(n * scene.record_period)
        lags.observe(simulation.frame())
        lags.observe(simulation.frame())  # looking twice counts once
    found = lags.columns()
    assert len(np.unique(found["lag"])) > 3
    # straight swimmers: each window's displacement is its length, in a, of frames of 0.5
    np.testing.assert_allclose(found["msd"], (0.5 * found["lag"]) ** 2, rtol=1e-6)


@pytest.mark.parametrize("n_frames", [8, 16, 17, 20, 32, 64, 100, 192])
def test_windows_of_the_fit_start_later_and_later(n_frames):
    starts: list[float] = []
    choice = choose(starts.append, first=1.0, last=0.5 * n_frames, memory=Memory(0.0, 0.0, 0.0))
    assert choice.start == np.inf
    assert starts[-1] == 0.25 * n_frames
    assert np.all(np.diff(starts) > 0.0)


def test_intervals_of_the_diffusivity_of_correlated_walks_cover_the_truth():
    rng, n, n_frames, p = np.random.default_rng(5), 100, 64, 0.2
    about, clock = synthetic.info(n_swimmers=n, last_time=64.0, dimensions=2), np.arange(n_frames + 1.0)
    truth = 0.25 * (1.0 + p) / (1.0 - p) + 0.045  # unit steps of which a share p goes on, and noise of variance 0.09
    covered = fitted = 0
    for _ in range(300):
        angle = rng.uniform(0.0, 2.0 * np.pi, (n_frames + 1, n))
        for i in range(1, n_frames + 1):
            angle[i] = np.where(rng.random(n) < p, angle[i - 1], angle[i])
        step = np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=-1)
        noise = 0.3 * rng.normal(size=step.shape) * [1.0, 1.0, 0.0]
        position = np.cumsum(step + noise, axis=0)
        fit = an.ensemble_diffusivity(synthetic.lags(about, clock, position, step))
        if fit.linear:
            fitted += 1
            covered += fit.interval[0] <= truth <= fit.interval[1]
    assert fitted > 150
    assert abs(covered / fitted - 0.95) <= 4.0 * np.sqrt(0.95 * 0.05 / fitted)


def test_displacements_far_from_where_offsets_are_measured_keep_their_digits(tmp_path):
    changes = {
        "run.duration": 2.0, "run.time_step": 0.02,
        "record.every": 0.02, "swimmers.count": 2000, "run.precision": "f32",
    }  # fmt: skip
    text = FREE.replace("periodic, size: [50, 50, 50]", "open")
    text = text.replace("{kind: uniform}", "{kind: point, position: [1.0e5, 1.0e5, 1.0e5]}")
    squares = an.ensemble_msd(ps.run(scene_of(tmp_path, text, **changes)).lags)
    t, decay = squares.lag, 0.6
    expected = 6.0 * 0.05 * t + 2.0 / decay**2 * (decay * t - 1.0 + np.exp(-decay * t))
    assert np.all(np.abs(squares.value - expected) < 4.0 * squares.standard_error + 1e-3 * expected)


@pytest.mark.parametrize(
    ("correlation", "memory"),
    [
        (lambda lag: np.exp(-lag / 20.0), 24.0),  # the first lag beyond the persistence time
        (lambda lag: np.exp(-lag / 16.1), 24.0),
        (lambda lag: np.exp(-lag / 40.0) * np.cos(lag), 48.0),  # -0.64, 0.23, 0.37, -0.19 from 16 on
        (lambda lag: np.exp(-lag / 0.5), 1.0),  # gone at the first lag
        (lambda lag: np.ones_like(lag), np.inf),
    ],
)
def test_directors_are_remembered_as_long_as_they_agree_or_disagree(correlation, memory):
    lag = np.array([1.0, 2.0, 4.0, 8.0, 16.0, 24.0, 32.0, 48.0])
    n = len(lag)
    rows = {
        "lag": lag, "group": np.zeros(n), "n_swimmers": np.full(n, 10), "n_windows": np.ones(n), "msd": lag,
        "fourth_moment": lag, "director_correlation": correlation(lag),
    }  # fmt: skip
    about = synthetic.info(n_swimmers=10)
    assert an.director_memory(make_table(LAGS_SCHEMA, rows, info=about)) == memory
    nothing = make_table(LAGS_SCHEMA, {name: values[:0] for name, values in rows.items()}, info=about)
    assert an.director_memory(nothing) == np.inf
