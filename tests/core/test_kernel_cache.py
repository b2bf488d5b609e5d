"""Compiled kernels that are not what was compiled are never run: Taichi would end the process."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from porous_swim.core import kernel_cache
from tests.support.commands import SMALL, environment, small_scene


@pytest.fixture
def kernels(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A cache of two kernels and their list, sealed as at the end of a process."""
    folder = tmp_path / "taichi" / "ticache"
    folder.mkdir(parents=True)
    for name, content in {"a.tic": b"one", "b.tic": b"other", "ticache.tcb": b"list"}.items():
        (folder / name).write_bytes(content)
    monkeypatch.setenv(kernel_cache.VARIABLE, str(tmp_path))
    monkeypatch.setitem(sys.modules, "taichi", sys.modules.get("taichi", sys))
    monkeypatch.setattr(kernel_cache, "_used", [])
    monkeypatch.setattr(kernel_cache, "_faults", [])
    monkeypatch.setattr(kernel_cache, "_end_taichi", lambda: None)
    kernel_cache.check()
    kernel_cache._seal(kernel_cache.os.getpid())
    kernel_cache._used.clear()
    return folder


def test_kernels_that_are_what_was_compiled_stay(kernels):
    kernel_cache.check()
    assert sorted(path.name for path in kernels.iterdir()) == ["a.tic", "b.tic", "ticache.tcb"]


@pytest.mark.parametrize("content", [b"other", b"on", b""])
def test_where_a_kernel_was_swapped_or_cut_short_all_go(kernels, content):
    (kernels / "a.tic").write_bytes(content)
    kernel_cache.check()
    assert list(kernels.iterdir()) == []


def test_a_kernel_that_nobody_has_listed_stays(kernels):
    (kernels / "c.tic").write_bytes(b"new")
    kernel_cache.check()
    assert (kernels / "c.tic").exists()


def test_a_run_whose_cached_kernels_were_swapped_compiles_them_anew(tmp_path):
    command = [
        sys.executable,
        "-m",
        "porous_swim",
        "run",
        str(small_scene(tmp_path, SMALL)),
        "--no-recording",
        "--quiet",
    ]
    there = environment(**{kernel_cache.VARIABLE: tmp_path})
    subprocess.run(command, cwd=tmp_path, env=there, check=True, capture_output=True, timeout=300)
    files = sorted((tmp_path / "taichi" / "ticache").glob("*.tic"), key=lambda path: path.stat().st_size)
    files[-1].write_bytes(files[-2].read_bytes())
    subprocess.run(command, cwd=tmp_path, env=there, check=True, capture_output=True, timeout=300)
