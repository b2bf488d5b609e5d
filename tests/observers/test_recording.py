"""The recording, read back: every number that it shows, and what happens when a run or a disk ends early."""

from __future__ import annotations

import dataclasses
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import rerun_cli
from rerun.chunk import RrdReader
from scipy.spatial.transform import Rotation

from porous_swim.core.errors import RunError
from porous_swim.observers.base import Every, Frame
from porous_swim.observers.rerun import colloids
from porous_swim.observers.rerun.about import About
from porous_swim.observers.rerun.recording import Recording
from porous_swim.observers.rerun.recording_size import LARGE_RECORDING, recording_size, recording_warning
from porous_swim.obstacles.field import ObstacleField
from porous_swim.obstacles.wall import THICKNESS
from tests.support.engines import plane_wall
from tests.support.frames import cubic_lattice, free_space, hexagonal_crystal, single_colloid, walk

SWIMMERS, TRAILS = np.arange(1, 25), np.array([2, 7, 11])
N_FRAMES, PERIOD, TIME_STEP = 60, 50, 0.01


def recording(path: Path, field: ObstacleField, **changes: Any) -> Recording:
    """A recording with everything stated."""
    shown = {name: changes.pop(name, of) for name, of in (("swimmers", SWIMMERS), ("trails", TRAILS))}
    n_steps, provenance = (N_FRAMES - 1) * PERIOD, {"seed": 1, "scene_id": "3fa9"}
    about = dataclasses.replace(About("crystal", "A test.", "test", TIME_STEP, n_steps, 1.0, provenance), **changes)
    return Recording(path, Every(PERIOD), field, about, **shown)


def write(
    path: Path, field: ObstacleField, *, interrupted: bool = False, seed: int = 1, pauses: int = 0
) -> list[Frame]:
    """Record a walk, with some pauses longer than the SDK's own tick of 0.2 s; return its frames."""
    frames = list(walk(field, n_swimmers=30, n_frames=N_FRAMES, period=PERIOD, time_step=TIME_STEP, seed=seed))
    observer = recording(path, field)
    for number, frame in enumerate(frames):
        observer.observe(frame)
        if number < pauses:
            time.sleep(0.3)
    observer.finish(interrupted=interrupted)
    return frames


def column(path: Path, entity: str, component: str, *, static: bool = False) -> list:
    """All rows of one component, in the order of time."""
    rows = []
    for chunk in RrdReader(path).stream().filter(content=entity):
        batch = chunk.to_record_batch()
        if component in batch.schema.names and chunk.is_static == static:
            steps = [0] * batch.num_rows if static else batch.column("step").to_pylist()
            rows += zip(steps, batch.column(component).to_pylist(), strict=True)
    return [value for _, value in sorted(rows, key=lambda row: row[0])]


@pytest.fixture(scope="module")
def crystal(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, ObstacleField, list[Frame]]:
    """A finished recording of a monolayer, with its field and frames."""
    path = tmp_path_factory.mktemp("recording") / "recording.rrd"
    field = hexagonal_crystal()
    return path, field, write(path, field)


def wrapped(position: np.ndarray, field: ObstacleField) -> np.ndarray:
    """`position` in the box, single precision."""
    edge = np.where(field.box > 0.0, field.box, np.inf)
    return (position - np.floor(position / edge) * np.where(field.box > 0.0, field.box, 0.0)).astype(np.float32)


def test_positions_and_states_come_back_bit_for_bit(crystal):
    path, field, frames = crystal
    expected = [wrapped(frame.position[SWIMMERS], field) for frame in frames]
    assert np.array_equal(column(path, "/world/swimmers", "Points3D:positions"), expected)
    states = column(path, "/world/swimmers", "Points3D:class_ids")
    assert np.array_equal(states, [frame.state[SWIMMERS] for frame in frames])
    assert len(np.unique(states)) == 3


def test_an_open_field_shows_positions_as_they_are(tmp_path: Path):
    frames = write(tmp_path / "open.rrd", single_colloid())
    positions = column(tmp_path / "open.rrd", "/world/swimmers", "Points3D:positions")
    assert np.array_equal(positions, [frame.position[SWIMMERS].astype(np.float32) for frame in frames])


def test_colloids_are_drawn_once_at_their_size(crystal):
    path, field, _ = crystal
    (centers,) = column(path, "/world/colloids", "Ellipsoids3D:centers", static=True) or column(
        path, "/world/colloids", "InstancePoses3D:translations", static=True
    )
    assert np.array_equal(centers, field.centers.astype(np.float32))
    (half_sizes,) = column(path, "/world/colloids", "Ellipsoids3D:half_sizes", static=True)
    assert np.array_equal(half_sizes, np.full((len(field.centers), 3), 3.5, dtype=np.float32))


def test_trails_end_at_their_swimmers_and_break_where_the_box_repeats(tmp_path: Path):
    path, field = tmp_path / "r.rrd", cubic_lattice(cells=2)  # small, so that swimmers leave it
    frames = write(path, field)
    segments = np.array(column(path, "/world/tracked/trails", "LineStrips3D:strips"))  # (frame, trail, 2, 3)
    shown = np.array([wrapped(frame.position[TRAILS], field) for frame in frames])
    assert np.array_equal(segments[:, :, 1], shown)
    length = np.linalg.norm(segments[:, :, 1] - segments[:, :, 0], axis=-1)
    moved = np.linalg.norm(np.diff([frame.position[TRAILS] for frame in frames], axis=0), axis=-1)
    # single precision of coordinates up to 24: an error below 1e-6 at either end
    assert length[1:] == pytest.approx(moved, abs=4e-6)
    assert np.abs(np.diff(shown, axis=0)).max() > field.box.max() / 2  # a face was crossed
    assert length.max() < field.box.max() / 2


def test_arrows_show_the_directors_of_the_tracked_swimmers(crystal):
    path, _, frames = crystal
    vectors = np.array(column(path, "/world/tracked/directors", "Arrows3D:vectors"))
    direction = vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)
    assert direction == pytest.approx(np.array([frame.director[TRAILS] for frame in frames]), abs=2e-7)


def test_histograms_hold_all_that_was_fed(crystal):
    path, _, frames = crystal
    for name in ("residence", "winding", "hop_time"):
        pictures = column(path, f"/histograms/{name}", "BarChart:values")
        n_fed = sum(len(getattr(frame, name)) for frame in frames)
        counts = pictures[-1][0]["buffer"]
        assert np.sum(counts) == n_fed > 0, name
        assert len(pictures) > 10  # it grows


def test_series_are_the_fractions_and_counts_of_the_frames(crystal):
    path, _, frames = crystal
    for state, name in enumerate(("free", "bound", "contact")):
        values = np.ravel(column(path, f"/series/fraction/{name}", "Scalars:scalars"))
        assert values == pytest.approx([np.mean(frame.state == state) for frame in frames], abs=1e-15)
    hops = np.ravel(column(path, "/series/events/hops", "Scalars:scalars"))
    assert np.array_equal(hops, [frame.counts.n_hops / 30 for frame in frames])


def test_lanes_hold_the_changes_of_state(crystal):
    path, _, frames = crystal
    states = np.array([frame.state[TRAILS[0]] for frame in frames])
    names = np.array(["free", "bound", "in contact"])[states]
    expected = [name for i, name in enumerate(names) if i == 0 or name != names[i - 1]]
    assert np.ravel(column(path, f"/states/swimmer_{TRAILS[0]:06d}", "StateChange:state")).tolist() == expected


def test_a_recording_carries_its_layout_and_provenance(crystal):
    path, _, _ = crystal
    assert RrdReader(path).blueprints()
    assert column(path, "/__properties/provenance", "scene_id", static=True) == [["3fa9"]]
    summary = column(path, "/summary", "TextDocument:text", static=True)[-1][0]
    assert "Finished" in summary


def test_results_given_before_the_end_stand_in_the_summary(tmp_path: Path):
    observer = recording(tmp_path / "r.rrd", hexagonal_crystal())
    for frame in walk(hexagonal_crystal(), n_swimmers=30, n_frames=2):
        observer.observe(frame)
    observer.set_summary("| residence time | 36.1 |")
    observer.finish(interrupted=False)
    assert "36.1" in column(tmp_path / "r.rrd", "/summary", "TextDocument:text", static=True)[-1][0]


def test_an_interrupted_run_says_so_in_summary_and_log(tmp_path: Path):
    path = tmp_path / "r.rrd"
    observer = recording(path, hexagonal_crystal())
    for frame in walk(hexagonal_crystal(), n_swimmers=30, n_frames=5, period=PERIOD):
        observer.observe(frame)
    observer.finish(interrupted=True)
    assert "**Interrupted** at step 200 of 2,950" in column(path, "/summary", "TextDocument:text", static=True)[-1][0]
    assert column(path, "/log", "TextLog:text")[-1] == ["interrupted at step 200 of 2950"]


def test_changing_a_frame_after_it_was_seen_changes_nothing_in_the_file(crystal, tmp_path: Path):
    path, field, frames = crystal
    observer = recording(tmp_path / "r.rrd", field)
    for frame in frames:
        names = [item.name for item in dataclasses.fields(frame)]
        numbers = ("step", "time", "counts", "ensemble", "has_colloids")
        arrays = {name: np.copy(getattr(frame, name)) for name in names if name not in numbers}
        copy = dataclasses.replace(frame, **arrays)
        observer.observe(copy)
        for name in arrays:
            getattr(copy, name)[...] = 1
    observer.finish(interrupted=False)
    # the squared displacements too: they count from the first frame, which must not change
    for entity, component in (
        ("/world/swimmers", "Points3D:positions"),
        ("/world/tracked/trails", "LineStrips3D:strips"),
        ("/world/tracked/directors", "Arrows3D:vectors"),
        ("/series/msd", "Scalars:scalars"),
    ):
        assert np.array_equal(column(tmp_path / "r.rrd", entity, component), column(path, entity, component))


def compare(path: Path, other: Path) -> int:
    """Exit status of Rerun's own comparison: 0 for equal contents."""
    command = [Path(rerun_cli.__file__).parent / "rerun", "rrd", "compare", path, other]
    return subprocess.run(command, capture_output=True, check=False).returncode


def test_equal_runs_give_equal_recordings_and_another_seed_gives_another(crystal, tmp_path: Path):
    path, field, _ = crystal
    write(tmp_path / "same.rrd", field, pauses=5)
    write(tmp_path / "other.rrd", field, seed=2)
    assert compare(path, tmp_path / "same.rrd") == 0
    assert compare(path, tmp_path / "other.rrd") != 0


@pytest.mark.parametrize("aspect_ratio", [1.0, 0.25])
def test_a_recording_takes_fourteen_bytes_for_a_sphere_in_a_frame_and_twice_that_for_a_rod(
    tmp_path: Path, aspect_ratio
):
    field = cubic_lattice()
    sizes = []
    for n_frames in (20, 120):
        path = tmp_path / f"{n_frames}.rrd"
        observer = recording(path, field, swimmers=np.arange(2000), trails=np.arange(0), n_steps=n_frames * PERIOD,
                             aspect_ratio=aspect_ratio)  # fmt: skip
        (frame,) = walk(field, n_swimmers=2000, n_frames=1)
        random = np.random.default_rng(1)
        for i in range(n_frames):
            position = frame.position + random.normal(size=frame.position.shape)
            turned = random.permutation(frame.director)
            frame = dataclasses.replace(frame, step=i * PERIOD, time=i * 0.5, position=position, director=turned)
            observer.observe(frame)
        observer.finish(interrupted=False)
        sizes.append(path.stat().st_size)
    # 12.9 bytes, or 24.9; the difference leaves fixed costs out
    expected = recording_size(n_frames=100, n_swimmers=2000, n_trails=0, rods=aspect_ratio < 1.0)
    assert sizes[1] - sizes[0] == pytest.approx(expected, rel=0.1)


def test_a_recording_that_would_be_large_is_announced_with_what_to_change():
    assert recording_warning(n_frames=400, n_swimmers=200, n_trails=20) is None
    warning = recording_warning(n_frames=2000, n_swimmers=10_000, n_trails=20)
    assert warning is not None
    assert "261 MB" in warning
    assert "record.swimmers" in warning
    assert recording_size(n_frames=2000, n_swimmers=1900, n_trails=0) < LARGE_RECORDING


@pytest.mark.parametrize("normal", [[0.0, -1.0, 0.0], [2.0 / 3.0, -2.0 / 3.0, 1.0 / 3.0]])
def test_a_wall_is_a_slab_whose_upper_face_is_its_plane_below_the_swimmers(tmp_path: Path, normal: list[float]):
    dimensions, point = 3 if normal[2] else 2, np.array([5.0, 40.0, 0.0])
    frames = list(
        walk(free_space(dimensions=dimensions), n_swimmers=30, n_frames=3, period=PERIOD, time_step=TIME_STEP)
    )
    observer = recording(tmp_path / "r.rrd", plane_wall(point, normal, dimensions))
    for frame in frames:
        observer.observe(frame)
    observer.finish(interrupted=False)

    def last(component: str) -> np.ndarray:
        return np.array(column(tmp_path / "r.rrd", "/world/colloids", component, static=True)[-1][0])

    turn = Rotation.from_quat(last("Boxes3D:quaternions"))
    center, half_size = last("Boxes3D:centers"), last("Boxes3D:half_sizes")
    corners = center + turn.apply(half_size * np.array(np.meshgrid(*[[-1, 1]] * 3)).reshape(3, -1).T)
    above = (corners - point) @ normal
    # single precision of coordinates up to 128
    assert above.max() == pytest.approx(0.0, abs=1e-5)
    assert above.min() == pytest.approx(-THICKNESS, abs=1e-5)
    seen = turn.inv().apply(frames[-1].position[SWIMMERS] - center)
    wide = [0, 1] if dimensions == 3 else [0]
    assert np.all(np.abs(seen[:, wide]) < half_size[wide])


@pytest.mark.parametrize("field", [free_space(), cubic_lattice(cells=2), single_colloid(dimensions=2)])
def test_every_kind_of_field_can_be_recorded(tmp_path: Path, field: ObstacleField):
    write(tmp_path / "r.rrd", field)
    assert RrdReader(tmp_path / "r.rrd").blueprints()
    assert not (tmp_path / "r.rrd.part").exists()


def test_a_crowded_field_is_drawn_as_points_and_what_was_visited_as_spheres(tmp_path: Path, monkeypatch):
    monkeypatch.setattr(colloids, "MAX_TRANSLUCENT", 100)
    monkeypatch.setattr("porous_swim.observers.rerun.recording.MAX_TRANSLUCENT", 100)
    field = hexagonal_crystal()
    frames = write(tmp_path / "r.rrd", field)
    (points,) = column(tmp_path / "r.rrd", "/world/colloids", "Points3D:positions", static=True)
    assert np.array_equal(points, field.centers.astype(np.float32))
    visited = np.unique([frame.colloid[TRAILS] for frame in frames])
    (half_sizes,) = column(tmp_path / "r.rrd", "/world/visited", "Ellipsoids3D:half_sizes", static=True)
    assert len(half_sizes) == len(visited)


def test_a_recording_appears_under_its_name_only_when_it_is_whole(tmp_path: Path):
    path = tmp_path / "r.rrd"
    observer = recording(path, hexagonal_crystal())
    for frame in walk(hexagonal_crystal(), n_swimmers=30, n_frames=3):
        observer.observe(frame)
    assert [file.name for file in tmp_path.iterdir()] == ["r.rrd.part"]
    observer.finish(interrupted=False)
    assert [file.name for file in tmp_path.iterdir()] == ["r.rrd"]


def test_a_missing_folder_is_one_sentence(tmp_path: Path):
    observer = recording(tmp_path / "none" / "r.rrd", hexagonal_crystal())
    (frame,) = walk(hexagonal_crystal(), n_swimmers=30, n_frames=1)
    with pytest.raises(RunError, match="cannot be written here"):
        observer.observe(frame)
    observer.finish(interrupted=True)  # what failed is left alone


FULL_DISK = """
import dataclasses, resource, sys
import numpy as np
sys.path.insert(0, {tests!r})
from tests.support.frames import hexagonal_crystal
from porous_swim.core.errors import RunError
from porous_swim.observers.rerun import stream
from test_recording import recording, walk

stream._FLUSH_SECONDS = 3.0  # the patience with a writer that hangs; it is not the fact under test
resource.setrlimit(resource.RLIMIT_FSIZE, (200_000, 200_000))
field = hexagonal_crystal()
(frame,) = walk(field, n_swimmers=2000, n_frames=1)
observer = recording({path!r}, field, swimmers=np.arange(2000))
random = np.random.default_rng(1)
try:
    for i in range(100):
        position = random.normal(size=(2000, 3))
        observer.observe(dataclasses.replace(frame, step=50 * i, time=0.5 * i, position=position))
    observer.finish(interrupted=False)
except RunError as error:
    print(error)
    observer.finish(interrupted=True)
"""


def test_a_full_disk_is_one_sentence(tmp_path: Path):
    # a limit on the size of files stands for the disk: the write fails in the same place
    path = tmp_path / "r.rrd"
    code = FULL_DISK.format(tests=str(Path(__file__).parent), path=str(path))
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr
    (sentence,) = done.stdout.splitlines()
    assert "disk full" in sentence
    assert not path.exists()
