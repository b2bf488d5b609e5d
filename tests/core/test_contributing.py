"""What CONTRIBUTING.md shows works, and what it and the hooks name is there."""

from __future__ import annotations

import re
import subprocess
import sys
import tomllib
from pathlib import Path

import yaml

from tests.support.commands import ROOT, environment

TEXT = (ROOT / "CONTRIBUTING.md").read_text()
BLOCKS = re.findall(r"^### (?:A|An) (\w+)\n.*?^```python\n(.*?)^```", TEXT, flags=re.M | re.S)


def test_every_way_to_add_a_part_works_as_it_is_written(tmp_path: Path) -> None:
    assert [name for name, _ in BLOCKS] == ["layout", "release", "flow", "motility", "observer", "statistic", "column"]
    for name, code in BLOCKS:
        (tmp_path / f"a_{name}.py").write_text(code)
    modules = ", ".join(f"a_{name}" for name, _ in BLOCKS)
    done = subprocess.run(
        [sys.executable, "-c", f"import {modules}; print('passed')"], cwd=tmp_path, env=environment(),
        capture_output=True, text=True, timeout=600,
    )  # fmt: skip
    assert (done.returncode, done.stdout.splitlines()[-1:]) == (0, ["passed"]), done.stderr


def test_files_that_it_names_are_there() -> None:
    links = re.findall(r"\]\(([a-z/]+\.md)", TEXT)
    modules = re.findall(r"`([a-z_]+/[a-z_/]+\.py)`", TEXT)
    assert len(links) >= 3
    assert len(modules) >= 3
    assert all((ROOT / link).is_file() for link in links)
    assert all((ROOT / "porous_swim" / module).is_file() for module in modules)


def test_the_hooks_are_the_first_checks_of_the_integration() -> None:
    hooks = yaml.safe_load((ROOT / ".pre-commit-config.yaml").read_text())["repos"][0]["hooks"]
    commands = [hook["entry"].removesuffix(" --fix") for hook in hooks]
    assert commands == ["ruff check", "ruff format", "mypy", "lint-imports"]
    integration = (ROOT / ".ci" / "run").read_text()
    assert all(f".venv/bin/{command}" in integration for command in commands)
    tools = " ".join(tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["optional-dependencies"]["lint"])
    assert all(tool in tools for tool in ("ruff", "mypy", "import-linter"))
