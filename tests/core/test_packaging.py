"""What is in a wheel, and what the installed package needs to find."""

from __future__ import annotations

import subprocess
import sys
import tomllib
import zipfile
from importlib.metadata import entry_points, version
from pathlib import Path

import pytest
import yaml

import porous_swim
from porous_swim.scene.schema import json_schema
from porous_swim.scene.shipped import NAME_PATTERN
from tests.support.commands import ROOT, SCENES


@pytest.fixture(scope="module")
def wheel(tmp_path_factory) -> zipfile.ZipFile:
    folder = tmp_path_factory.mktemp("wheel")
    command = ["pip", "wheel", "--quiet", "--no-deps", "--no-build-isolation", "--wheel-dir", str(folder), str(ROOT)]
    subprocess.run([sys.executable, "-m", *command], check=True, capture_output=True)
    (path,) = folder.glob("*.whl")
    return zipfile.ZipFile(path)


def test_a_wheel_holds_every_module_scene_and_the_schema(wheel):
    names = set(wheel.namelist())
    modules = {str(path.relative_to(ROOT)) for path in (ROOT / "porous_swim").rglob("*.py")}
    scenes = {f"porous_swim/{path.relative_to(ROOT)}" for path in (ROOT / "scenes").rglob("*.*")}
    assert modules | scenes | {"porous_swim/scene/scene.schema.json", "porous_swim/bench/swim.c"} <= names
    assert "porous_swim/py.typed" in names  # without it the types of the interface are not read
    assert any(name.endswith("licenses/LICENSE") for name in names)
    assert not any(name.startswith(("tests", "scenes")) for name in names)


def test_the_scenes_in_a_wheel_are_those_of_the_repository(wheel):
    for path in SCENES:
        assert wheel.read(f"porous_swim/scenes/{path.name}") == path.read_bytes()


def test_the_entry_point_is_the_command_line():
    (script,) = entry_points(group="console_scripts", name="porous-swim")
    assert script.value == "porous_swim.commands.cli:main"


def test_the_version_is_that_of_the_project_file():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    assert version("porous_swim") == porous_swim.__version__ == project["version"]


def test_the_citation_and_the_changelog_are_of_this_version():
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    assert citation["version"] == porous_swim.__version__
    assert citation["license"] == tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["license"]
    paper = citation["preferred-citation"]
    assert (paper["doi"], paper["volume"], paper["start"]) == ("10.1039/C4SM02785J", 11, 3396)
    assert [author["family-names"] for author in paper["authors"]] == ["Spagnolie", "Moreno-Flores", "Bartolo", "Lauga"]
    headings = [line for line in (ROOT / "CHANGELOG.md").read_text().splitlines() if line.startswith("## ")]
    assert headings[:2] == ["## [Unreleased]", f"## [{citation['version']}] - {citation['date-released']}"]


def test_names_of_templates_are_names_of_scenes():
    assert json_schema()["properties"]["name"]["pattern"] == f"^{NAME_PATTERN}$"


def test_reading_results_loads_neither_taichi_nor_rerun():
    code = "import sys, porous_swim as ps; ps.load_results, ps.analysis, ps.theory; print(set(sys.modules))"
    found = subprocess.run([sys.executable, "-c", code], cwd=Path(porous_swim.__file__).parents[1], check=True,
                           capture_output=True, text=True).stdout  # fmt: skip
    assert "'numpy'" in found
    assert "'taichi'" not in found
    assert "'rerun'" not in found
