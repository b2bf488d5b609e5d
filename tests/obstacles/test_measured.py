"""Bead tables as people have them: few digits, overlaps, duplicates, pixels, a box that does not fit."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from porous_swim.core.errors import SceneError
from porous_swim.obstacles.field import ObstacleField
from porous_swim.scene.scene import Scene

UNITS = {"length": "0.5 um", "speed": "5 um/s"}


def place(folder: Path, rows: np.ndarray, digits: str = "%.12g", **more: Any) -> ObstacleField:
    """A table of x, y, radius in the plane, in a box if `size` is given."""
    np.savetxt(folder / "beads.csv", rows, delimiter=",", header="x,y,radius", comments="", fmt=digits)
    size, units = more.pop("size", None), more.pop("units", None)
    domain = {"boundary": "open"} if size is None else {"boundary": "periodic", "size": size}
    data = {
        "swimmers": {"count": 1, "dipole_strength": 0.8, "release": {"kind": "point", "position": [-90, 0]}},
        "obstacles": {"layout": "file", "path": "beads.csv", **more},
        "domain": {"dimensions": 2, **domain},
        "run": {"time_step": 0.01, "duration": 1},
    } | ({} if units is None else {"units": units})
    return Scene.from_mapping(data, folder=folder).place_obstacles()


def touching() -> np.ndarray:
    """A hexagonal crystal of touching beads of radius 3.5, turned by 0.3."""
    i, j = (index.ravel() for index in np.meshgrid(np.arange(6), np.arange(6)))
    place = 7.0 * (i + 0.5 * j + 1j * np.sqrt(0.75) * j) * np.exp(0.3j)
    return np.c_[place.real, place.imag, np.full(36, 3.5)]


@pytest.mark.parametrize("digits", ["%.12g", "%.9g", "%.6f", "%.4f"])
def test_a_touching_crystal_of_few_digits_is_taken_as_it_is_and_said(tmp_path, digits):
    field = place(tmp_path, touching(), digits)
    assert field.centers[:, :2] == pytest.approx(touching()[:, :2], abs=5e-5)
    if digits in ("%.6f", "%.4f"):  # rounded by half a unit: overlaps of up to 2 sqrt(2) times that over 7
        assert any("pairs of colloids overlap by up to" in note for note in field.notes)


def test_more_is_accepted_on_request(tmp_path):
    with pytest.raises(SceneError, match=r"pairs overlap, by up to .* raise obstacles\.tolerance"):
        place(tmp_path, touching(), "%.1f")
    assert len(place(tmp_path, touching(), "%.1f", tolerance=0.03).radii) == 36  # 2 sqrt(2) 0.05/7 = 0.02


OVERLAPPING = np.array([[0.0, 0.0, 2.0], [3.8, 0.0, 2.0], [0.0, 10.0, 1.0], [0.0, 12.9, 2.0], [30.0, 30.0, 1.0]])


def test_overlaps_are_counted_with_their_depth_and_a_remedy(tmp_path):
    with pytest.raises(SceneError) as caught:
        place(tmp_path, OVERLAPPING)
    assert "colloids 0 and 1 overlap by 0.2: centres 3.8 apart, radii 2 and 2; 2 pairs overlap" in str(caught.value)
    assert "by up to 5 % of their summed radii: set obstacles.overlaps to shrink or drop" in str(caught.value)


def test_lengths_are_told_in_um_beside_a_where_the_scene_has_units(tmp_path):
    with pytest.raises(SceneError) as caught:  # a is 0.5 um
        place(tmp_path, OVERLAPPING, units=UNITS, unit="a")
    told = "overlap by 0.2 a (0.1 µm): centres 3.8 a (1.9 µm) apart, radii 2 a (1 µm) and 2 a (1 µm)"
    assert told in str(caught.value)


def test_what_does_not_fit_a_lattice_is_told_in_um_too(tmp_path):
    lattice = {"layout": "square", "radius": "2 um", "spacing": "3.5 um", "cells": [2, 2]}
    data = {
        "units": UNITS,
        "swimmers": {"count": 1, "dipole_strength": 0.8},
        "obstacles": lattice,
        "domain": {"dimensions": 2},
        "run": {"time_step": "1 ms", "duration": "2.5 ms"},
    }
    with pytest.raises(SceneError) as caught:  # a/U is 0.1 s
        Scene.from_mapping(data)
    spacing, duration = sorted(str(caught.value).splitlines())
    assert spacing.endswith(
        "colloids of radius 4 a (2 µm) overlap by 1 a (0.5 µm): expected at least 8 a (4 µm), found 7 a (3.5 µm)"
    )
    assert "0.025 a/U (0.0025 s) is not a whole number of steps of 0.01 a/U (0.001 s)" in duration


def test_radii_are_bounded_in_half_lengths_whatever_the_unit_of_the_table(tmp_path):
    tiny = np.array([[0.0, 0.0, 0.0004]])  # px
    assert place(tmp_path, tiny, unit="px", scale=5.0).radii == pytest.approx([0.002])  # allowed from 0.001
    with pytest.raises(SceneError, match=r"radius of 0.001 a .* to 1e\+06 a .*, found 0.0008 a \(0.0004 µm\)"):
        place(tmp_path, tiny, unit="um", units=UNITS)


@pytest.mark.parametrize(
    ("header", "hint"),
    [
        ("x;y;radius", "; separate columns by commas, not by semicolons, and write decimals with a point"),
        ("x\ty\tradius", "; separate columns by commas, not by tabs, and write decimals with a point"),
        ("x [um],y [um],radius [um]", "; write the names in small letters and without units (obstacles.unit says what"),
        ("X,Y,Radius", "; write the names in small letters and without units"),
        (
            "x_um;y_um;radius_um",
            "; separate columns by commas, not by semicolons, and write decimals with a point; write",
        ),
        ("left,top,width", "found left, top, width"),
    ],
)
def test_a_first_line_that_is_nearly_right_gets_a_hint(tmp_path, header, hint):
    (tmp_path / "beads.csv").write_text(f"{header}\n1,2,3\n")
    data = {
        "swimmers": {"count": 1, "dipole_strength": 0.8, "release": {"kind": "point", "position": [-90, 0]}},
        "obstacles": {"layout": "file", "path": "beads.csv"},
        "domain": {"dimensions": 2, "boundary": "open"},
        "run": {"time_step": 0.01, "duration": 1},
    }
    with pytest.raises(SceneError) as caught:
        Scene.from_mapping(data, folder=tmp_path).place_obstacles()
    assert hint in str(caught.value)
    assert ("; " in str(caught.value)) == hint.startswith("; ") or ";" in header


def test_shrunk_colloids_touch_and_are_counted(tmp_path):
    field = place(tmp_path, OVERLAPPING, overlaps="shrink")
    assert field.radii == pytest.approx([1.9, 1.9, 2.9 / 3.0, 5.8 / 3.0, 1.0])
    assert field.notes == (
        "4 of 5 colloids were shrunk, by up to 5 %, until they overlap no more (obstacles.overlaps)",
    )


def test_the_smaller_of_two_that_overlap_is_dropped(tmp_path):
    field = place(tmp_path, OVERLAPPING, overlaps="drop")
    assert field.centers[:, :2].tolist() == [[0.0, 0.0], [0.0, 12.9], [30.0, 30.0]]
    assert field.notes == ("2 of 5 colloids were dropped, as they overlap larger or equal ones (obstacles.overlaps)",)


def detections() -> np.ndarray:
    """Each of 9 beads detected five times within 0.05, two of them beside the edge of the box of 30 by 30."""
    rng = np.random.default_rng(3)
    ticks = np.array([0.01, 10.0, 20.0])
    beads = np.stack(np.meshgrid(ticks, ticks), axis=-1).reshape(-1, 2)
    seen = (beads[:, None, :] + rng.uniform(-0.05, 0.05, (9, 5, 2))).reshape(-1, 2) % 30.0
    return np.c_[seen, rng.uniform(1.9, 2.1, 45)]


def test_duplicates_are_recognised_and_merged_on_request(tmp_path):
    with pytest.raises(SceneError, match=r"36 duplicates: .* give obstacles\.merge"):
        place(tmp_path, detections(), size=[30, 30])
    field = place(tmp_path, detections(), size=[30, 30], merge=0.2)
    rows = detections().reshape(9, 5, 3)
    # a mean across the edge of the box: by the angle, which is right to second order of 0.05/30
    angle = np.angle(np.exp(2j * np.pi * rows[:, :, :2] / 30.0).mean(axis=1)) * 30.0 / (2.0 * np.pi)
    apart = (field.centers[:, None, :2] - angle + 15.0) % 30.0 - 15.0
    assert np.linalg.norm(apart, axis=2).min(axis=0).max() < 1e-5
    assert np.sort(field.radii) == pytest.approx(np.sort(rows[:, :, 2].mean(axis=1)))
    assert "45 detections were merged into 9 colloids (obstacles.merge 0.2)" in field.notes


def test_pixels_and_micrometres_become_half_lengths(tmp_path):
    rows = np.array([[10.0, 20.0, 4.0], [40.0, 20.0, 8.0]])
    um = place(tmp_path, rows, unit="um", units=UNITS)  # a is 0.5 um
    assert (um.centers[:, 0].tolist(), um.radii.tolist(), um.notes) == ([20.0, 80.0], [8.0, 16.0], ())
    pixels = place(tmp_path, rows, unit="px", scale="0.25 um", units=UNITS)
    assert (pixels.centers[:, 0].tolist(), pixels.radii.tolist()) == ([5.0, 20.0], [2.0, 4.0])
    assert place(tmp_path, rows, unit="px", scale=0.5).radii.tolist() == [2.0, 4.0]
    assert place(tmp_path, rows, unit="a", units=UNITS).notes == ()
    assert "read in half-lengths a, though the scene has units" in place(tmp_path, rows, units=UNITS).notes[0]


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"unit": "px"}, "obstacles.scale: expected with unit: px"),
        ({"scale": 2.0}, "obstacles.scale: expected with unit: px"),
        ({"unit": "um"}, "obstacles.unit: 'um' needs a `units` section"),
        ({"unit": "kg", "units": UNITS}, "obstacles.unit: expected a length"),
        ({"merge": 0.0}, "obstacles.merge: "),
    ],
)
def test_keys_of_a_table_that_make_no_sense_are_named(tmp_path, keys, message):
    with pytest.raises(SceneError) as caught:
        place(tmp_path, OVERLAPPING, **keys)
    assert str(caught.value).startswith(message)


def test_a_scene_with_a_table_in_pixels_is_the_same_when_it_is_saved(tmp_path):
    place(tmp_path, np.array([[10.0, 20.0, 4.0]]), unit="px", scale=0.5)
    (tmp_path / "run").mkdir()
    data = {
        "swimmers": {"count": 1, "dipole_strength": 0.8, "release": {"kind": "point", "position": [-90, 0]}},
        "obstacles": {"layout": "file", "path": "beads.csv", "unit": "px", "scale": "0.25 um"},
        "domain": {"dimensions": 2, "boundary": "open"}, "run": {"time_step": 0.01, "duration": 1}, "units": UNITS,
    }  # fmt: skip
    scene = Scene.from_mapping(data, folder=tmp_path)
    scene.save(tmp_path / "run")
    from porous_swim.scene.scene import load_scene

    again = load_scene(tmp_path / "run/scene.yaml")
    assert again.place_obstacles().radii == pytest.approx(scene.place_obstacles().radii)
    assert scene.replace({"run.seed": 3}).place_obstacles().radii.tolist() == [2.0]


def test_a_table_that_does_not_fit_its_box_is_told_with_both_extents(tmp_path):
    x, y = (tick.ravel() for tick in np.meshgrid(np.arange(5.0, 100.0, 10.0), np.arange(5.0, 50.0, 10.0)))
    rows = np.c_[x, y, np.full(50, 2.0)]
    assert place(tmp_path, rows, size=[100, 50]).notes == ()
    swapped = place(tmp_path, rows + np.array([0.0, 3.0, 0.0]), size=[53, 100], overlaps="drop").notes
    assert (
        "25 of 50 colloids lie outside of the box and are moved into it: the table has centres from 5 to 95 in x, "
        in (swapped[0])
    )
    assert "and the box goes from 0 to 53" in swapped[0]
    doubled = place(tmp_path, rows, size=[200, 50]).notes
    assert doubled == (
        "a part of the box has no colloids, 106 wide: the table has centres from 5 to 95 in x, and the box goes from 0 "
        "to 200",
    )


def test_what_was_done_to_colloids_is_in_the_warnings_of_the_scene(tmp_path):
    np.savetxt(tmp_path / "beads.csv", OVERLAPPING, delimiter=",", header="x,y,radius", comments="")
    data = {
        "swimmers": {"count": 1, "dipole_strength": 0.8, "release": {"kind": "point", "position": [-90, 0]}},
        "obstacles": {"layout": "file", "path": "beads.csv", "overlaps": "drop"},
        "domain": {"dimensions": 2, "boundary": "open"}, "run": {"time_step": 0.01, "duration": 1},
    }  # fmt: skip
    assert any("2 of 5 colloids were dropped" in text for text in Scene.from_mapping(data, folder=tmp_path).warnings())
