"""Parts from other packages are used, described and refused like our own."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Literal

import numpy as np
import pytest

import porous_swim as ps
from porous_swim.core.parts import Length, Radius
from porous_swim.core.registry import forget, models_in, parts_of, plugin_of
from porous_swim.obstacles.field import ObstacleField
from porous_swim.scene.schema import scene_page
from tests.support.commands import small_scene
from tests.support.plugins import SCENE, install, run_with

SECTIONS: dict[str, Any] = {
    "swimmers": {"count": 2, "dipole_strength": 0.5, "release": {"kind": "point", "position": [0, 0, 20]}},
    "run": {"time_step": 0.01, "duration": 1.0},
}


class Twin(ps.Layout):
    """Two equal colloids beside each other."""

    OPEN = True

    layout: Literal["twin"]
    radius: Radius
    """Radius of both."""
    gap: Length = 1.0
    """Distance between their surfaces."""

    def n_colloids(self, domain: Any, folder: Path) -> int:
        return 2

    def place(self, domain: Any, rng: np.random.Generator, folder: Path) -> ObstacleField:
        x = self.radius + 0.5 * self.gap
        return ObstacleField.of_spheres(
            np.array([[-x, 0, 0], [x, 0, 0]]), np.full(2, self.radius), np.zeros(3), domain.dimensions
        )


@pytest.fixture
def twin() -> Iterator[type[Twin]]:
    yield ps.register(Twin)
    forget(Twin)


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("site")
    install(folder)
    return folder


def scene_of(**obstacles: Any) -> ps.Scene:
    return ps.Scene.from_mapping({**SECTIONS, "obstacles": {"layout": "twin", "radius": 3.0, **obstacles}})


def test_a_scene_of_plugins_runs_and_says_so(installed: Path, tmp_path: Path) -> None:
    path = small_scene(tmp_path, SCENE)
    done = run_with(installed, "-m", "porous_swim", "run", path, "--out", "out", "--quiet", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    results = ps.load_results(tmp_path / "out")
    assert results.summary["provenance"]["packages"]["swim-extras"] == "1.2"
    colloids, frames = results.colloids.to_pydict(), results.trajectory.to_pydict()
    assert np.hypot(colloids["x"], colloids["y"]) == pytest.approx(9.0, rel=1e-15)
    start = np.array(frames["time"]) == 0.0
    assert np.array(frames["y"])[start] == pytest.approx(np.linspace(-6.0, 6.0, 60), abs=1e-12)
    # the flow: swimmers of a dipole strength of 0 go straight on; those that it draws do not, but do not turn
    assert np.array(frames["ex"]) == pytest.approx(1.0, abs=1e-12)
    assert np.abs(np.array(frames["y"])[~start].reshape(10, 60) - np.linspace(-6.0, 6.0, 60)).max() > 0.01


def test_the_drift_of_a_plugin_is_what_it_says(installed: Path, tmp_path: Path) -> None:
    code = (
        "import json, porous_swim as ps; v, w = ps.drift([[0, 3, 4]], [[1, 0, 0]], radius=2.0, dipole_strength=10.0, "
        "hydrodynamics='attraction'); print(json.dumps([v.tolist(), w.tolist()]))"
    )
    done = run_with(installed, "-c", code, cwd=tmp_path)
    velocity, rate = json.loads(done.stdout.splitlines()[-1])
    assert velocity[0] == pytest.approx([1.0, -0.16 * 0.6, -0.16 * 0.8], rel=1e-14)  # alpha A/R^3 = 20/125
    assert rate == [[0.0, 0.0, 0.0]]


TUMBLING = """\
swimmers:
  count: 4000
  dipole_strength: 0
  release: {kind: start_line, length: 12.0}
  motility: {kind: tumbling, run_time: 2 s}
units: {length: 1 um, speed: 2 um/s, temperature: 293 K, viscosity: 1 mPa s}
obstacles: {layout: none}
domain: {dimensions: 2}
run: {time_step: 0.05, duration: 4, seed: 1, threads: 1}
record: {every: 1, swimmers: 4000, trails: 0}
"""


def test_a_motility_of_a_plugin_moves_swimmers_by_the_numbers_of_the_scene_file(
    installed: Path, tmp_path: Path
) -> None:
    path = tmp_path / "tumbling.yaml"
    path.write_text(TUMBLING)
    done = run_with(installed, "-m", "porous_swim", "run", path, "--out", "out", "--quiet", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    results = ps.load_results(tmp_path / "out")
    assert results.summary["provenance"]["packages"]["swim-extras"] == "1.2"
    frames = results.trajectory.to_pydict()
    ex = np.array(frames["ex"]).reshape(5, 4000)
    for time, found in enumerate(ex):  # a run of 2 s lasts 4 a/U; who has tumbled points anywhere; four standard errors
        assert abs(found.mean() - np.exp(-time / 4.0)) <= 4.0 * found.std() / np.sqrt(4000)
    assert np.hypot(ex, np.array(frames["ey"]).reshape(5, 4000)) == pytest.approx(1.0, abs=1e-6)


def test_an_observer_of_a_plugin_looks_at_the_run_of_a_scene_file(installed: Path, tmp_path: Path) -> None:
    path = tmp_path / "seen.yaml"
    ours = TUMBLING.replace("motility: {kind: tumbling, run_time: 2 s}", "")
    path.write_text(ours.replace("trails: 0}", "trails: 0, observers: [{kind: heading, file: seen.txt, period: 40}]}"))
    done = run_with(installed, "-m", "porous_swim", "run", path, "--out", "out", "--quiet", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    lines = (tmp_path / "seen.txt").read_text().splitlines()
    assert lines == ["0 1.000000 0.000000", "2 1.000000 0.000000", "4 1.000000 0.000000"]
    assert "{kind: heading, file: seen.txt, period: 40}" in (tmp_path / "out" / "scene.yaml").read_text()
    results = ps.load_results(tmp_path / "out")
    assert results.summary["provenance"]["packages"]["swim-extras"] == "1.2"
    code = "import sys, porous_swim as ps; print(*(ps.load_scene(path).scene_id for path in sys.argv[1:]))"
    (tmp_path / "unseen.yaml").write_text(ours)
    said = run_with(installed, "-c", code, path, tmp_path / "unseen.yaml", cwd=tmp_path).stdout.split()
    assert said[-1] == said[-2]


def test_without_a_package_that_has_observers_a_scene_that_names_one_is_refused() -> None:
    with pytest.raises(ps.SceneError, match=r"record\.observers.*: no ObserverPart is registered"):
        ps.Scene.from_mapping({**SECTIONS, "obstacles": {"layout": "none"}, "record": {"observers": [{"kind": "x"}]}})


LINE = "release: {kind: start_line, length: 12.0}"
TRAILS = "trails: 0"
MISTAKES = [
    (
        ("ring_radius", "ring_radus"),
        ":3:40: obstacles.ring_radus: unknown key; did you mean `ring_radius`? allowed",
    ),
    (("layout: ring", "layout: rng"), "found 'rng'; did you mean `ring`?"),
    (("count: 9}", "count: 9.5}"), ":3:65: obstacles.count: expected a whole number, found 9.5"),
    (("radius: 2.0", "radius: 2 um"), "obstacles.radius: expected a number in a (strings need a `units` section)"),
    (("radius: 2.0", "radius: 4.0"), "obstacles.ring_radius: colloids "),
    (("dimensions: 2", "dimensions: 2, boundary: periodic"), "domain.boundary: a ring stands in open space"),
    (("length: 12.0", "length: 20.0"), "swimmers.release.length: swimmer"),
    (
        ("kind: attraction", "kind: attracton"),
        "hydrodynamics.kind: expected `none`, `image_dipole`,",
    ),
    ((TRAILS, f"{TRAILS}, observers: [{{kind: headin}}]"), "kind: expected `heading`, found 'headin'; did you mean"),
    ((TRAILS, f"{TRAILS}, observers: [{{kind: heading}}]"), ".file: this key is required and missing (The file"),
    (
        (TRAILS, f"{TRAILS}, observers: [{{kind: heading, file: a, perod: 3}}]"),
        ".perod: unknown key; did you mean `period`? allowed with kind: heading: kind, file, period",
    ),
    ((LINE, f"{LINE}, motility: {{kind: tumbling}}"), "swimmers.motility.run_time: this key is required and missing"),
    (
        (LINE, f"{LINE}, motility: {{kind: tumbling, runtime: 3}}"),
        "swimmers.motility.runtime: unknown key; did you mean `run_time`?",
    ),
    (
        (LINE, f"{LINE}, motility: {{kind: tumbling, run_time: 0}}"),
        ":1:125: swimmers.motility.run_time: expected at least 0.001, found 0",
    ),
    (
        (LINE, f"{LINE}, motility: {{kind: tumblin, run_time: 3}}"),
        "swimmers.motility.kind: expected `steady` or `tumbling`, found 'tumblin'; did you mean `tumbling`?",
    ),
]
TRY_ALL = """
import json, sys, numpy, porous_swim as ps
for path in sys.argv[1:]:
    try:
        scene = ps.load_scene(path)
        field = scene.place_obstacles()
        scene.place_swimmers(field, lambda s, A: numpy.ones_like(s))
    except ps.SceneError as error:
        print(json.dumps(str(error)))
"""


def test_mistakes_in_the_keys_of_a_plugin_are_told_like_ours(installed: Path, tmp_path: Path) -> None:
    paths = [tmp_path / f"{number}.yaml" for number in range(len(MISTAKES))]
    for path, (change, _) in zip(paths, MISTAKES, strict=True):
        path.write_text(SCENE.replace(*change))
    done = run_with(installed, "-c", TRY_ALL, *paths, cwd=tmp_path)
    said = [json.loads(line) for line in done.stdout.splitlines() if line.startswith('"')]
    for path, (_, message), found in zip(paths, MISTAKES, said, strict=True):
        assert message in found
        assert all(line.startswith(f"{path}:") for line in found.splitlines())


def test_the_command_line_tells_a_mistake_in_a_plugin_in_one_line(installed: Path, tmp_path: Path) -> None:
    path = small_scene(tmp_path, SCENE.replace("radius: 2.0", "radius: 0"))
    done = run_with(installed, "-m", "porous_swim", "run", path, cwd=tmp_path)
    assert (done.returncode, done.stderr) == (2, f"{path}:3:35: obstacles.radius: expected at least 0.001, found 0\n")


def test_the_schema_knows_the_keys_of_plugins(installed: Path, tmp_path: Path) -> None:
    done = run_with(installed, "-m", "porous_swim", "schema", cwd=tmp_path)
    ring = json.loads(done.stdout)["$defs"]["Ring"]
    assert set(ring["required"]) == {"layout", "radius", "ring_radius", "count"}
    assert ring["properties"]["count"]["description"] == "Number of colloids."
    page = run_with(installed, "-m", "porous_swim", "schema", "--page", cwd=tmp_path).stdout
    assert "## `obstacles` with `layout: ring`" in page
    assert (
        "| `ring_radius` | Radius of the circle on which their centres are. | a | number > 0 and <= 1e+06 | required |"
        in page
    )


def test_a_broken_plugin_costs_one_sentence(tmp_path: Path) -> None:
    site = tmp_path / "site"
    install(site)
    (site / "swim_extras" / "ring.py").write_text("import there_is_no_such_module\n")
    (tmp_path / "plain.yaml").write_text(
        SCENE.replace("layout: ring, radius: 2.0, ring_radius: 9.0, count: 9", "layout: none")
    )
    done = run_with(site, "-m", "porous_swim", "check", tmp_path / "plain.yaml", cwd=tmp_path)
    assert done.returncode == 0
    (line,) = done.stderr.splitlines()
    assert line == (
        "warning: the plug-in ring of the package swim-extras cannot be loaded, so that scenes do not know it: "
        "ModuleNotFoundError: No module named 'there_is_no_such_module'"
    )


def test_ours_is_taken_where_a_plugin_has_its_word(tmp_path: Path) -> None:
    site = tmp_path / "site"
    install(site)
    ring = site / "swim_extras" / "ring.py"
    ring.write_text(ring.read_text().replace('Literal["ring"]', 'Literal["square"]'))
    own = "import porous_swim.obstacles.layouts as ours; assert parts['square'] is ours.Square"
    begin = "import porous_swim as ps; from porous_swim.core.registry import parts_of; "
    drift = "ps.drift([[0, 0, 9]], [[0, 0, 1]], radius=1, dipole_strength=1); "
    for first, said in (("", "cannot be loaded"), (drift, "swim_extras.ring.Ring is left out: layout: square")):
        load = f"{begin}{first}import porous_swim.scene.scene; parts = parts_of(ps.Layout); {own}"
        done = run_with(site, "-c", load, cwd=tmp_path)
        assert done.returncode == 0, done.stderr
        (line,) = [line for line in done.stderr.splitlines() if line.startswith("warning")]
        assert said in line


def test_the_identity_of_a_scene_holds_the_version_of_its_plugins(installed: Path, tmp_path: Path) -> None:
    site, path, ours = tmp_path / "site", tmp_path / "plugins.yaml", small_scene(tmp_path)
    install(site)
    (metadata,) = site.glob("*.dist-info/METADATA")
    metadata.write_text(metadata.read_text().replace("Version: 1.2", "Version: 1.3"))
    path.write_text(SCENE)
    code = "import sys, porous_swim as ps; print(*(ps.load_scene(path).scene_id for path in sys.argv[1:]))"
    lines = [run_with(each, "-c", code, path, ours, cwd=tmp_path).stdout.splitlines()[-1] for each in (installed, site)]
    (first, plain), (second, plain_again) = map(str.split, lines)
    assert first != second
    assert plain == plain_again == ps.load_scene(ours).scene_id  # without any plug-in


def test_a_registered_class_is_a_layout_of_scenes(twin: type[Twin]) -> None:
    scene = scene_of(gap=2.0)
    assert isinstance(scene.obstacles, Twin)
    assert scene.domain.boundary == "open"
    assert scene.place_obstacles().centers[:, 0].tolist() == [-4.0, 4.0]
    assert ps.Scene.from_mapping(json.loads(json.dumps(scene.model_dump()))).scene_id == scene.scene_id
    assert "## `obstacles` with `layout: twin`" in scene_page()
    with pytest.raises(ps.SceneError, match=r"obstacles\.radus: unknown key; did you mean `radius`"):
        scene_of(radus=2.0)
    plugin = plugin_of(Twin)
    assert plugin is not None
    assert plugin.package == "test_plugins.Twin"


def test_a_class_that_is_forgotten_is_unknown() -> None:
    forget(ps.register(Twin))
    with pytest.raises(ps.SceneError, match="found 'twin'"):
        scene_of()
    assert Twin not in models_in(ps.Layout)
    assert plugin_of(parts_of(ps.Layout)["single"]) is None


def test_what_is_no_part_is_not_registered(twin: type[Twin]) -> None:
    class Other(Twin):
        """Another with the same word."""

    class Nameless(ps.Layout):
        """No word chooses it."""

    class Placeless(ps.Layout):
        """It places nothing."""

        layout: Literal["placeless"]

    for part, error, message in (
        (Other, ValueError, "layout: twin is taken by test_plugins.Twin; choose another word"),
        (Nameless, TypeError, "expected the field `layout: Literal"),
        (Placeless, TypeError, "a Layout needs n_colloids and place; see porous_swim.Layout"),
        (ps.Layout, TypeError, "expected a class derived from Layout, Release, Flow, Motility or ObserverPart"),
        (int, TypeError, "expected a class derived from Layout, Release, Flow, Motility or ObserverPart"),
    ):
        with pytest.raises(error, match=message):
            ps.register(part)


def test_parts_of_a_plugin_pass_the_checks_that_ours_pass(installed: Path, tmp_path: Path) -> None:
    code = """
import porous_swim.testing as testing
testing.check_layout({"layout": "ring", "radius": 2.0, "ring_radius": 9.0, "count": 9})
testing.check_release({"kind": "start_line", "length": 12.0})
testing.check_flow("attraction")
testing.check_motility({"kind": "tumbling", "run_time": 0.5})
print("passed")
"""
    done = run_with(installed, "-c", code, cwd=tmp_path)
    assert (done.returncode, done.stdout.splitlines()[-1:]) == (0, ["passed"]), done.stderr


def test_a_class_that_is_defined_again_takes_the_place_of_the_first() -> None:
    def define(gap: float) -> type[ps.Layout]:
        class Again(Twin):
            """A layout of a notebook, whose cell is run twice."""

            layout: Literal["again"]

            def n_colloids(self, domain: Any, folder: Path) -> int:
                return round(gap)

        return ps.register(Again)

    define(1.0)
    second = define(3.0)
    try:
        assert scene_of(layout="again").n_colloids == 3
        assert parts_of(ps.Layout)["again"] is second
    finally:
        forget(second)
