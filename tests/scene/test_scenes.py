"""Every scene that ships, shortened, through the whole way from YAML to a run folder."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from rerun.chunk import RrdReader

import porous_swim as ps
from porous_swim.results.results import Results
from tests.support.commands import SCENES

N_STEPS, N_FRAMES, COUNT, RECORDED = 400, 5, 48, 20
NAMES = {
    "crystal", "crystal_thermal", "takagi", "single_colloid", "wall", "bullseye", "lattice_3d", "packing", "beads",
    "free_space",
}  # fmt: skip
# Contact scales an offset of length R = A + 1 to the surface in single precision: the factor, each component and the
# length that it is checked by are rounded by at most 2^-24 of R. Asked for are 2e-6 where that is less.
BELOW_CONTACT, ROUNDING = 2e-6, 3.0 * 2.0**-24


def shortened(path: Path) -> ps.Scene:
    scene = ps.load_scene(path)
    dt = scene.run.time_step
    return scene.replace(
        {
            "run.duration": N_STEPS * dt,
            "swimmers.count": min(COUNT, scene.swimmers.count),
            "record": {"every": N_STEPS // (N_FRAMES - 1) * dt, "swimmers": RECORDED, "trails": 5},
        }
        | ({"swimmers.release": {"kind": "parallel", "height": 1.0}} if path.stem in ("single_colloid", "wall") else {})
    )


@pytest.fixture(scope="module", params=SCENES, ids=lambda path: path.stem)
def run(request, tmp_path_factory) -> tuple[ps.Scene, Results]:
    scene = shortened(request.param)
    return scene, ps.run(scene, out=tmp_path_factory.mktemp("runs") / scene.name)


def test_the_promised_scenes_ship():
    assert {path.stem for path in SCENES} == NAMES


def test_a_run_of_a_scene_leaves_all_that_it_promises(run):
    scene, results = run
    assert {path.name for path in results.folder.iterdir()} >= {
        "scene.yaml", "recording.rrd", "colloids.parquet", "encounters.parquet", "timeseries.parquet",
        "trajectory.parquet", "summary.json",
    }  # fmt: skip
    assert not list(results.folder.glob("*.part"))
    n_recorded = min(RECORDED, scene.swimmers.count)
    assert results.timeseries.num_rows == N_FRAMES
    assert results.trajectory.num_rows == N_FRAMES * n_recorded
    assert ps.load_scene(results.folder / "scene.yaml").scene_id == scene.scene_id
    RrdReader(results.folder / "recording.rrd").store()


def test_every_statistic_of_a_summary_has_value_error_counts_and_unit(run):
    _, results = run
    summary = json.loads((results.folder / "summary.json").read_text(), parse_constant=pytest.fail)
    assert summary["status"] == "finished"
    found = list(_statistics(summary))
    assert len(found) > 15
    for statistic in found:
        scaled = summary["units"] is not None and statistic["unit"] not in ("", "turns")
        more = {"physical"} if scaled else set()
        assert set(statistic) - {"warning"} == {"value", "standard_error", "n", "n_censored", "unit"} | more
        assert statistic.get("warning", "a sentence.").endswith(".")
        assert (statistic["value"] is None) or (statistic["n"] + statistic["n_censored"] > 0 or statistic["value"] == 0)


def test_recorded_swimmers_keep_their_contact_height_above_every_colloid(run):
    scene, results = run
    position, director = (_vectors(results.trajectory, names) for names in (("x", "y", "z"), ("ex", "ey", "ez")))
    centers, radii = _vectors(results.colloids, ("x", "y", "z")), results.colloids["radius"].to_numpy()
    offset = position[:, None] - centers
    for axis, edge in enumerate(results.info.box):
        if edge > 0.0:
            offset[..., axis] -= edge * np.round(offset[..., axis] / edge)
    R = np.linalg.norm(offset, axis=2)
    height, sine = R - radii, np.einsum("ijk,ik->ij", offset, director) / R
    if scene.name == "wall":  # whose normal is along z
        height, sine = offset[..., 2], director[:, 2:]
    gamma = scene.swimmers.aspect_ratio
    near = height < 2.0
    contact = np.ones(R.shape)  # of spheres, and of rods on their tips
    contact[near] = ps.contact_height(
        np.arcsin(sine[near]), radius=np.broadcast_to(radii, R.shape)[near], aspect_ratio=gamma
    )
    # in free space there is nothing to keep away from, and `all` of nothing holds
    assert np.all(height - contact > -np.maximum(BELOW_CONTACT, ROUNDING * R))
    if results.info.dimensions == 2:
        assert np.all(position[:, 2] == 0.0)


def test_directors_stay_unit_vectors(run):
    _, results = run
    norm = np.linalg.norm(_vectors(results.trajectory, ("ex", "ey", "ez")), axis=1)
    np.testing.assert_allclose(norm, 1.0, atol=4e-7)  # three roundings of single precision, 1.2e-7 each


def _vectors(table, names: tuple[str, str, str]) -> np.ndarray:
    return np.stack([table[name].to_numpy() for name in names], axis=1)


def _statistics(node):
    """All maps of a summary that have a standard error."""
    if isinstance(node, dict):
        if "standard_error" in node:
            yield node  # what is inside is the same in the laboratory's units
            return
        for value in node.values():
            yield from _statistics(value)


def test_the_noise_of_takagi_is_that_of_a_cylinder_as_long_and_as_thick_as_its_rods():
    # M. M. Tirado and J. Garcia de la Torre, J. Chem. Phys. 71, 2581 (1979) and 73, 1986 (1980), fits to 1 %
    length, width, kT, viscosity, speed = 2.0, 0.3, 4.1e-3, 1e-3, 20.0  # um, pN um, pN s/um^2, um/s
    p = length / width
    along = (np.log(p) - 0.207 + 0.980 / p - 0.133 / p**2) / (2.0 * np.pi)
    across = (np.log(p) + 0.839 + 0.185 / p + 0.233 / p**2) / (4.0 * np.pi)
    D = kT / (viscosity * length) * (along + across) / 2.0  # over directions in the plane
    D_r = 3.0 * kT * (np.log(p) - 0.662 + 0.917 / p - 0.050 / p**2) / (np.pi * viscosity * length**3)
    a = length / 2.0
    scene = ps.load_scene(next(path for path in SCENES if path.stem == "takagi"))
    assert scene.swimmers.aspect_ratio == width / length
    assert scene.translational_diffusion == pytest.approx(D / (a * speed), rel=2e-3)  # three digits
    assert scene.rotational_diffusion == pytest.approx(D_r * a / speed, rel=2e-3)
