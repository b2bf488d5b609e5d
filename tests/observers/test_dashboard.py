"""The pages of a recording: what they show of a real run is what the tables of that run say."""

from __future__ import annotations

import itertools
from collections import Counter
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest
from rerun.chunk import RrdReader
from test_recording import PERIOD, column, recording

import porous_swim as ps
from porous_swim.core.stopwatch import Stopwatch
from porous_swim.observers.rerun import network
from porous_swim.obstacles.field import ObstacleField
from porous_swim.results.run_folder import RunFolder
from porous_swim.running.observation import Observers
from tests.support.commands import SMALL
from tests.support.engines import plane_wall
from tests.support.frames import cubic_lattice, free_space, hexagonal_crystal, single_colloid, walk

# a box so small that swimmers hop across its border; weaker dipoles than a crystal's leave sooner
CHANGES = {"run.duration": 40.0, "swimmers.dipole_strength": 2.0}


def small(folder: Path, **changes: object) -> ps.Scene:
    """The small scene, run long enough to hop."""
    (folder / "small.yaml").write_text(SMALL)
    return ps.load_scene(folder / "small.yaml").replace({**CHANGES, **changes})


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run folder."""
    folder = tmp_path_factory.mktemp("dashboard")
    ps.run(small(folder), out=folder / "run")
    return folder / "run"


def table(folder: Path, name: str) -> dict[str, np.ndarray]:
    """The columns of a table."""
    read = pq.read_table(folder / f"{name}.parquet")
    return {column: read[column].to_numpy() for column in read.schema.names}


def last_bars(folder: Path, name: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Heights, left edges and widths of the last picture of a distribution."""
    path, entity = folder / "recording.rrd", f"/histograms/{name}"
    values, left = (column(path, entity, f"BarChart:{part}")[-1][0]["buffer"] for part in ("values", "abscissa"))
    return np.array(values), np.array(left), np.array(column(path, entity, "BarChart:widths")[-1])


def moves(folder: Path) -> list[tuple[tuple[int, ...], tuple[int, ...], float]]:
    """Hosts (colloid and image) and flight time of all hops, swimmer by swimmer, from the table of encounters."""
    rows = table(folder, "encounters")
    order = np.lexsort((rows["start_time"], rows["swimmer"]))
    host = np.column_stack([rows[name] for name in ("colloid", "image_x", "image_y", "image_z")])
    found = []
    for one, following in itertools.pairwise(order):
        if rows["swimmer"][one] == rows["swimmer"][following] and tuple(host[one]) != tuple(host[following]):
            time = rows["start_time"][following] - rows["end_time"][one]
            found.append((tuple(host[one].tolist()), tuple(host[following].tolist()), float(time)))
    return found


def test_the_network_at_the_end_has_the_hops_of_the_table_of_encounters(folder):
    path, colloids = folder / "recording.rrd", table(folder, "colloids")
    center = np.column_stack([colloids[axis] for axis in "xyz"])
    box = np.array([20.0, 10.0 * np.sqrt(3.0), 0.0])
    expected: Counter = Counter()
    for left, entered, _ in moves(folder):
        end = center[entered[0]] + (np.array(entered[1:]) - left[1:]) * box
        # a line ends in the middle, so four decimals of it (single precision has five here) name the pair
        expected[left[0], entered[0], *np.round(0.5 * (center[left[0]] + end), 4)] += 1
    strips, hops, left, entered = (
        column(path, "/world/hops", name)[-1] for name in ("LineStrips3D:strips", "hops", "left", "entered")
    )
    assert np.array(strips)[:, 0] == pytest.approx(center[left], abs=2e-6)  # single precision of numbers below 32
    ends = np.round(np.array(strips, dtype=float)[:, 1], 4)
    assert {(a, b, *end): n for a, b, end, n in zip(left, entered, ends, hops, strict=True)} == expected
    assert sum(hops) == sum(expected.values()) > 50
    assert any(a == b for a, b in zip(left, entered, strict=True)) or len(set(zip(left, entered, strict=True))) < len(
        hops
    )  # some differ by the image alone


def test_the_network_grows_to_its_end(folder):
    path = folder / "recording.rrd"
    totals = [sum(hops) for hops in column(path, "/world/hops", "hops")]
    assert 10 < len(totals) <= 21  # twenty and the last
    assert all(np.diff(totals) >= 0)
    captions = column(path, "/network", "TextDocument:text")
    assert [f"**{n:,} hops**" in caption[0] for n, caption in zip(totals, captions, strict=True)] == [True] * len(
        totals
    )


def test_only_the_busiest_lines_are_drawn_and_the_caption_says_so(tmp_path: Path, monkeypatch):
    monkeypatch.setattr(network, "MAX_LINES", 3)
    observer, counts = recording(tmp_path / "r.rrd", hexagonal_crystal()), Counter()
    for frame in walk(hexagonal_crystal(), n_swimmers=200, n_frames=60, period=PERIOD):
        observer.observe(frame)
        for (left, *from_image), (entered, *to_image) in frame.hops.tolist():
            counts[left, entered, *np.subtract(to_image, from_image).tolist()] += 1
    observer.finish(interrupted=False)
    drawn = column(tmp_path / "r.rrd", "/world/hops", "hops")[-1]
    assert sorted(drawn) == sorted(counts.values())[-3:]
    caption = column(tmp_path / "r.rrd", "/network", "TextDocument:text")[-1][0]
    assert f"{sum(counts.values()):,} hops" in caption
    assert f"{len(counts):,} directed pairs" in caption
    assert "the 3 busiest" in caption


def test_height_and_pitch_are_those_of_the_first_swimmer_in_the_trajectory(folder):
    rows, colloids = table(folder, "trajectory"), table(folder, "colloids")
    first = {name: values[rows["swimmer"] == 0] for name, values in rows.items()}
    image = np.column_stack([first[f"image_{axis}"] for axis in "xyz"])
    center = np.column_stack([colloids[axis] for axis in "xyz"])[first["colloid"]]
    offset = np.column_stack([first[axis] for axis in "xyz"]) - center - image * [20.0, 10.0 * np.sqrt(3.0), 0.0]
    director = np.column_stack([first[f"e{axis}"] for axis in "xyz"])
    distance = np.linalg.norm(offset, axis=1)
    path = folder / "recording.rrd"
    height, pitch = (np.ravel(column(path, f"/followed/{name}", "Scalars:scalars")) for name in ("height", "pitch"))
    assert len(height) == len(distance) == 401
    # rounding of coordinates below 100; the sine, since the arc sine is steep at its ends
    assert height == pytest.approx(distance - 3.5, abs=1e-12)
    assert np.sin(pitch) == pytest.approx(np.sum(offset * director, axis=1) / distance, abs=1e-12)


def test_the_swimmer_followed_has_its_trail_to_itself(folder):
    path, rows = folder / "recording.rrd", table(folder, "trajectory")
    segments = np.array(column(path, "/world/followed/trails", "LineStrips3D:strips"))
    assert segments.shape == (401, 1, 2, 3)
    own = np.column_stack([rows[axis][rows["swimmer"] == 0] for axis in "xyz"])
    # steps rather than places, which are wrapped; single precision of numbers below 32, twice
    assert (segments[1:, 0, 1] - segments[1:, 0, 0]) == pytest.approx(np.diff(own, axis=0), abs=8e-6)


def test_bars_stand_where_the_values_are(folder):
    counts, left, width = last_bars(folder, "hop_time")
    times = np.array([time for _, _, time in moves(folder)])
    assert np.array_equal(counts, [np.sum((a < times) & (times < a + w)) for a, w in zip(left, width, strict=True)])
    assert counts.sum() == len(times)


def test_survival_is_that_of_kaplan_and_meier(folder):
    rows = table(folder, "encounters")
    length, ended = np.round(rows["end_time"] - rows["start_time"], 9), ~rows["end_censored"]
    probability, left, width = last_bars(folder, "survival")
    assert left[-1] + width[-1] == pytest.approx(length.max(), rel=1e-6)  # nothing is known beyond the longest
    assert ended.sum() > 50
    assert (~ended).sum() > 10
    for time, value in zip(left, probability, strict=True):
        product = 1.0
        for end in np.unique(length[ended & (length <= time)]):
            product *= 1.0 - np.sum(ended & (length == end)) / np.sum(length >= end)
        assert value == pytest.approx(product, abs=1e-12)  # some hundred factors


@pytest.mark.parametrize("noise", ["brownian", "none"])
def test_frames_tell_every_hop_once_and_as_soon_as_it_is_counted(noise, tmp_path: Path):
    changes = {} if noise == "brownian" else {"noise": {"kind": "none"}, "run.time_step": 0.1}
    simulation = ps.Simulation(small(tmp_path, **changes))
    n_hops = n_ended = 0
    for _ in range(20):
        simulation.advance(simulation.scene.n_steps // 20)
        frame = simulation.frame()
        n_hops, n_ended = n_hops + len(frame.hops), n_ended + len(frame.residence)
        assert n_hops == frame.counts.n_hops
        assert len(frame.hop_time) == len(frame.hops)
        assert n_ended == frame.counts.n_escapes
        assert len(frame.under_way) == np.sum(frame.state > 0) == frame.counts.n_captures - n_ended
        assert np.all((frame.under_way >= 0.0) & (frame.under_way <= frame.time))
        assert np.all(np.any(frame.hops[:, 0] != frame.hops[:, 1], axis=1))
    assert n_hops > 10


@pytest.mark.parametrize("n_frames", [100, 107])  # of 200; every tenth is drawn, and has news
def test_the_last_pictures_of_an_interrupted_run_tell_all_that_ended(n_frames, tmp_path: Path):
    simulation, folder = ps.Simulation(small(tmp_path, **{"record.every": 0.2})), RunFolder.at(tmp_path / "run")
    observers = Observers(simulation, folder, Stopwatch(), progress=False, recording=True)
    observers.observe()
    for _ in range(n_frames):
        simulation.advance(simulation.scene.record_period)
        observers.observe()
    observers.results(rate=None)
    ended = ~table(folder.path, "encounters")["end_censored"]
    assert np.sum(last_bars(folder.path, "residence")[0]) == np.sum(ended) > 10
    assert np.sum(last_bars(folder.path, "hop_time")[0]) == len(moves(folder.path)) > 10


TABS = ("Residence", "Survival", "Winding", "Hop time")  # inside a page, and named like one
PAGES = ["Medium and swimmers", "One swimmer", "Hop network", "Distributions", "Summary"]


@pytest.mark.parametrize(
    ("field", "trails", "pages"),
    [
        (hexagonal_crystal(), [2, 7], PAGES),
        (hexagonal_crystal(), [], [PAGES[0], *PAGES[2:]]),
        (cubic_lattice(cells=2), [2], PAGES),
        (single_colloid(radius=5.0), [2], [*PAGES[:2], *PAGES[3:]]),
        (ObstacleField.of_spheres(np.full((1, 3), 8.0), np.array([4.0]), np.full(3, 16.0), 3), [2], PAGES),
        (plane_wall([0, 0, 0], [0, 0, 1]), [2], [*PAGES[:2], PAGES[4]]),
        (free_space(), [2], [PAGES[0], PAGES[4]]),
    ],
)
def test_pages_without_content_are_left_out(tmp_path: Path, field: ObstacleField, trails: list[int], pages: list[str]):
    walked = free_space() if not field.is_round else field
    observer = recording(tmp_path / "r.rrd", field, trails=np.array(trails, dtype=int))
    for frame in walk(walked, n_swimmers=30, n_frames=60, period=PERIOD):
        observer.observe(frame)
    observer.finish(interrupted=False)
    assert sorted(pages_of(tmp_path / "r.rrd")) == sorted(pages)


def pages_of(path: Path) -> list[str]:
    """Names of the pages of the layout that was sent last."""
    reader, found = RrdReader(path), []
    for layout in reader.blueprints():  # in no order, but the ids of rows begin with the time
        batches = [chunk.to_record_batch() for chunk in reader.stream(store=layout)]
        sent = max(max(batch.column("rerun.controls.RowId").to_pylist()) for batch in batches)
        name = "ContainerBlueprint:display_name"
        named = [row[0] for batch in batches if name in batch.schema.names for row in batch.column(name).to_pylist()]
        found.append((sent, named))
    return [page for page in max(found)[1] if page not in TABS]


def test_a_swimmer_in_space_is_shown_with_the_colloids_that_it_was_near(tmp_path: Path):
    field, near = cubic_lattice(cells=2), set()
    observer = recording(tmp_path / "r.rrd", field)
    for frame in walk(field, n_swimmers=30, n_frames=20, period=PERIOD):
        observer.observe(frame)
        near.add(int(frame.colloid[2]))  # the first of the trails
    observer.finish(interrupted=False)
    (centers,) = column(tmp_path / "r.rrd", "/world/followed/colloids", "Ellipsoids3D:centers", static=True)
    assert np.array_equal(centers, field.centers[sorted(near)].astype(np.float32))
