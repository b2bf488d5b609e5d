"""How a recording looks when it is opened: its layout, its time line, planes from above, rods, distributions."""

from __future__ import annotations

import io
import subprocess
import time
from pathlib import Path

import numpy as np
import pytest
import rerun_cli
from rerun.chunk import RrdReader
from scipy.spatial.transform import Rotation
from test_recording import N_FRAMES, PERIOD, SWIMMERS, TIME_STEP, TRAILS, column, recording, write

from porous_swim.observers.rerun import bodies
from porous_swim.observers.rerun.above import round_below
from porous_swim.observers.rerun.palette import BAR_COLOR, GROUND, STATE_COLORS
from porous_swim.obstacles.field import ObstacleField
from tests.support.engines import plane_wall
from tests.support.frames import cubic_lattice, free_space, hexagonal_crystal, single_colloid, walk
from tools.web_screenshot import chromium, web_viewer

UNITS = 2.0, 0.5  # um in a, s in a/U


def written(path: Path, field: ObstacleField, **options: object) -> list:
    """Record a walk in `field` with `options`; return its frames."""
    walked = free_space() if not field.is_round else field
    frames = list(walk(walked, n_swimmers=30, n_frames=N_FRAMES, period=PERIOD, time_step=TIME_STEP))
    observer = recording(path, field, **options)
    for frame in frames:
        observer.observe(frame)
    observer.finish(interrupted=False)
    return frames


def of_layout(path: Path, component: str) -> list:
    """All values of one component in the layout that was sent last."""
    reader, found = RrdReader(path), []
    for layout in reader.blueprints():  # in no order, but the ids of rows begin with the time
        batches = [chunk.to_record_batch() for chunk in reader.stream(store=layout)]
        sent = max(max(batch.column("rerun.controls.RowId").to_pylist()) for batch in batches)
        rows = [row for batch in batches if component in batch.schema.names for row in batch.column(component)]
        found.append((sent, [value for row in rows if row.is_valid for value in row.as_py()]))
    return max(found)[1]


def test_both_viewers_are_told_to_show_the_pages(tmp_path: Path):
    write(tmp_path / "r.rrd", hexagonal_crystal())
    command = [Path(rerun_cli.__file__).parent / "rerun", "rrd", "print", tmp_path / "r.rrd"]
    printed = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    orders = [line for line in printed.splitlines() if line.startswith("BlueprintActivationCommand")]
    assert orders
    assert all("make_active: true" in order for order in orders)


@pytest.mark.slow
@pytest.mark.skipif(chromium() is None, reason="there is no Chromium here to look with")
def test_a_browser_shows_the_pages(tmp_path: Path):
    # the ground of the views of space is a colour that Rerun's own layout does not have; the first page gives them more
    # than a third of the window (17 % of it was ground, where colloids and swimmers leave it free)
    import matplotlib.image

    write(tmp_path / "r.rrd", hexagonal_crystal())
    share, end = 0.0, time.monotonic() + 240.0
    with web_viewer(tmp_path / "r.rrd") as page:
        while share < 0.1 and time.monotonic() < end:
            picture = matplotlib.image.imread(io.BytesIO(page.screenshot()))[..., :3]
            share = float(np.mean(np.all(np.abs(255.0 * picture - GROUND) < 1.5, axis=-1)))
    assert share >= 0.1


@pytest.mark.parametrize(("units", "shown", "times", "seconds"), [(None, "step", "time_in_a_over_U", 1.0),
                                                                  (UNITS, "time", "time", 0.5)])  # fmt: skip
def test_the_time_line_counts_seconds_where_they_are_known_and_else_steps(tmp_path: Path, units, shown, times, seconds):
    path = tmp_path / "r.rrd"
    frames = written(path, hexagonal_crystal(), units=units)
    assert of_layout(path, "TimePanelBlueprint:timeline") == [shown]
    batches = [chunk.to_record_batch() for chunk in RrdReader(path).stream().filter(content="/world/swimmers")]
    moving = next(batch for batch in batches if "step" in batch.schema.names)
    assert moving.column("step").to_pylist() == [frame.step for frame in frames]
    # a duration is stored in whole nanoseconds
    nanoseconds = moving.column(times).cast("int64").to_numpy()
    assert nanoseconds == pytest.approx([1e9 * seconds * frame.time for frame in frames], abs=1.0)
    timelines = RrdReader(path).store().summary().split("timelines=")[1:]
    assert {text.split("]")[0] for text in timelines} == {"[", str(sorted(["step", times]))[:-1]}  # and no clock
    text = column(path, "/summary", "TextDocument:text", static=True)[-1][0]
    counts = "seconds" if units else f"steps of {TIME_STEP:g} a/U"
    assert f"The time line counts {counts}." in text


def test_series_and_distributions_of_a_scene_with_units_are_in_um_and_s(tmp_path: Path):
    (plain, scaled), (a, seconds) = (tmp_path / "plain.rrd", tmp_path / "scaled.rrd"), UNITS
    for path, units in ((plain, None), (scaled, UNITS)):
        written(path, hexagonal_crystal(), units=units)
    for entity, factor in (("/series/msd", a**2), ("/followed/height", a), ("/followed/pitch", 1.0)):
        one, other = (np.ravel(column(path, entity, "Scalars:scalars")) for path in (plain, scaled))
        assert other == pytest.approx(factor * one, rel=1e-14)
    for name, factor in (("residence", seconds), ("survival", seconds), ("hop_time", seconds), ("winding", 1.0)):
        entity = f"/histograms/{name}"
        one, other = (column(path, entity, "BarChart:abscissa")[-1][0]["buffer"] for path in (plain, scaled))
        assert np.array(other) == pytest.approx(factor * np.array(one), rel=1e-14)
    titles = of_layout(scaled, "ViewBlueprint:display_name")
    assert {"MSD (µm²)", "Height above the nearest colloid (µm)"} <= set(titles)
    assert not any("a/U" in title or "(a" in title for title in titles)


def test_bars_name_their_axes_and_have_the_colour_of_no_state(tmp_path: Path):
    written(tmp_path / "r.rrd", hexagonal_crystal())
    titles = of_layout(tmp_path / "r.rrd", "ViewBlueprint:display_name")
    for title in ("↑ encounters that ended   → residence time (a/U)", "↑ hops   → hop time (a/U)",
                  "↑ encounters that ended   → winding (turns)",
                  "↑ share of encounters that last longer   → time (a/U)"):  # fmt: skip
        assert title in titles
    red, green, blue = BAR_COLOR
    for name in ("residence", "survival", "hop_time", "winding"):
        colors = column(tmp_path / "r.rrd", f"/histograms/{name}", "BarChart:color")
        assert {tuple(color) for color in colors} == {((red << 24) + (green << 16) + (blue << 8) + 255,)}
    # as far from each state as two states are from each other: 100 of the cube's 442
    assert min(np.linalg.norm(np.subtract(BAR_COLOR, color)) for color in STATE_COLORS.values()) > 75.0


@pytest.mark.parametrize("field", [hexagonal_crystal(), single_colloid(radius=5.0, dimensions=2)])
def test_a_plane_is_seen_from_above_with_a_scale_bar(tmp_path: Path, field: ObstacleField):
    path = tmp_path / "r.rrd"
    written(path, field, units=UNITS)
    assert "3D" not in of_layout(path, "ViewBlueprint:class_identifier")
    assert of_layout(path, "ViewBlueprint:class_identifier").count("2D") >= 3

    def last(entity: str, component: str) -> np.ndarray:
        return np.array(column(path, entity, component, static=True)[-1][0])

    lens, size = (last("/world/above", f"Pinhole:{part}") for part in ("image_from_camera", "resolution"))
    turn, place = (last("/world/above", f"Transform3D:{part}") for part in ("mat3x3", "translation"))
    points = np.random.default_rng(1).uniform(-1.0, 1.0, (50, 3)) * [50.0, 50.0, 0.0] + place * [1.0, 1.0, 0.0]
    seen = (points - place) @ turn.reshape(3, 3)  # columns of the matrix are the camera's axes
    u, v, depth = (seen @ lens.reshape(3, 3)).T  # stored by columns
    # one unit of the picture is one a, x to the right and y upwards; single precision of a few hundred
    assert u / depth - 0.5 * size[0] == pytest.approx(points[:, 0] - place[0], abs=1e-3)
    assert v / depth - 0.5 * size[1] == pytest.approx(place[1] - points[:, 1], abs=1e-3)
    for entity in ("/world/scale", "/world/followed/scale"):
        (start, end), label = last(entity, "LineStrips3D:strips"), column(path, entity, "LineStrips3D:labels",
                                                                          static=True)[-1][0]  # fmt: skip
        number, unit = label.split()
        assert unit == "µm"
        assert np.linalg.norm(end - start) * UNITS[0] == pytest.approx(float(number), rel=1e-6)


def test_space_is_seen_from_a_corner(tmp_path: Path):
    written(tmp_path / "r.rrd", cubic_lattice(cells=2))
    written(tmp_path / "w.rrd", plane_wall([0, 0, 0], [0, 0, 1]))
    for name in ("r.rrd", "w.rrd"):
        views = of_layout(tmp_path / name, "ViewBlueprint:class_identifier")
        assert "2D" not in views
        assert "3D" in views


@pytest.mark.parametrize(("length", "bar"), [(1.0, 1.0), (1.99, 1.0), (4.99, 2.0), (50.0, 50.0), (0.099, 0.05)])
def test_scale_bars_have_round_lengths(length: float, bar: float):
    assert round_below(length) == pytest.approx(bar, rel=1e-12)


def test_rods_are_ellipsoids_along_their_directors(tmp_path: Path):
    path = tmp_path / "r.rrd"
    frames = written(path, single_colloid(radius=5.0), aspect_ratio=0.25)
    for entity, who in (("/world/swimmers", SWIMMERS), ("/world/tracked/swimmers", TRAILS)):
        centers = np.array(column(path, entity, "Ellipsoids3D:centers"))
        assert np.array_equal(centers, [frame.position[who].astype(np.float32) for frame in frames])
        half_sizes = np.reshape(column(path, entity, "Ellipsoids3D:half_sizes"), (-1, 3))
        assert np.array_equal(np.unique(half_sizes, axis=0), [[1.0, 0.25, 0.25]])
        quaternions = column(path, entity, "Ellipsoids3D:quaternions")
        axis = Rotation.from_quat(np.reshape(quaternions, (-1, 4))).apply([1.0, 0.0, 0.0])
        directors = np.concatenate([frame.director[who] for frame in frames])
        assert axis == pytest.approx(directors, abs=1e-6)  # single precision


def test_a_director_straight_back_has_a_turning_too():
    turned = bodies._turning(np.array([[-1.0, 0.0, 0.0], [-1.0, 1e-9, 0.0], [1.0, 0.0, 0.0]]))
    axis = Rotation.from_quat(turned).apply([1.0, 0.0, 0.0])
    assert axis == pytest.approx(np.array([[-1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]]), abs=1e-6)


def test_very_many_rods_are_lines_from_end_to_end(tmp_path: Path, monkeypatch):
    monkeypatch.setattr(bodies, "MAX_ELLIPSOIDS", 10)
    frames = written(tmp_path / "r.rrd", single_colloid(radius=5.0), aspect_ratio=0.25)
    strips = np.array(column(tmp_path / "r.rrd", "/world/swimmers", "LineStrips3D:strips"))  # (frame, swimmer, 2, 3)
    ends = [frame.position[SWIMMERS, None] + frame.director[SWIMMERS, None] * [[-1.0], [1.0]] for frame in frames]
    assert strips == pytest.approx(np.array(ends), abs=1e-5)  # single precision of numbers below 64
    assert column(tmp_path / "r.rrd", "/world/swimmers", "LineStrips3D:radii", static=True)[-1] == [0.25]
    tracked = column(tmp_path / "r.rrd", "/world/tracked/swimmers", "Ellipsoids3D:half_sizes")
    assert len(tracked) == N_FRAMES
