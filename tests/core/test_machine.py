"""What a process may use of its machine: processors, memory, limits; forks; and a home where nothing can be kept."""

from __future__ import annotations

import multiprocessing
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import porous_swim as ps
from porous_swim.core import machine
from porous_swim.core import process_limits as limits
from porous_swim.core.errors import DeviceError
from porous_swim.engine import backend
from porous_swim.obstacles.cells import build_cells
from porous_swim.scene.scene import Scene
from tests.support.commands import environment, small_scene

SCENE = {
    "swimmers": {"count": 16, "dipole_strength": 0.8, "release": {"kind": "point", "position": [-9, 0, 0]}},
    "noise": {"kind": "brownian", "translational_diffusion": 0.01},
    "obstacles": {"layout": "single", "radius": 5.0},
    "run": {"time_step": 0.02, "duration": 0.2, "device": "cpu"},
}


def groups(folder: Path, monkeypatch: pytest.MonkeyPatch, membership: str, files: dict[str, str]) -> None:
    """Control groups as the kernel shows them."""
    for name, text in files.items():
        path = folder / "sys" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    (folder / "proc/self").mkdir(parents=True)
    (folder / "proc/self/cgroup").write_text(membership)
    (folder / "proc/meminfo").write_text("MemTotal: 100 kB\nMemAvailable: 64000000 kB\n")
    monkeypatch.setattr(machine, "GROUPS", folder / "sys")
    monkeypatch.setattr(machine, "PROC", folder / "proc")
    monkeypatch.setattr("os.sched_getaffinity", lambda pid: set(range(8)), raising=False)


V1 = "4:cpu,cpuacct:/job/1\n9:memory:/job/1\n0::/\n"
QUOTAS = [
    ("0::/job/1\n", {"job/1/cpu.max": "max 100000\n"}, 8),
    ("0::/job/1\n", {"job/1/cpu.max": "max 100000\n", "job/cpu.max": "300000 100000\n"}, 3),  # of the group above
    ("0::/job/1\n", {"job/1/cpu.max": "150000 100000\n"}, 2),
    ("0::/job/1\n", {"job/1/cpu.max": "10000 100000\n"}, 1),
    ("0::/\n", {"cpu.max": "200000 100000\n"}, 2),  # in a container
    (V1, {"cpu/job/1/cpu.cfs_quota_us": "-1\n", "cpu/job/1/cpu.cfs_period_us": "100000\n"}, 8),
    (V1, {"cpu/job/1/cpu.cfs_quota_us": "200000\n", "cpu/job/1/cpu.cfs_period_us": "100000\n"}, 2),
    (V1, {"cpu,cpuacct/cpu.cfs_quota_us": "200000\n", "cpu,cpuacct/cpu.cfs_period_us": "100000\n"}, 2),
    ("", {}, 8),
]


@pytest.mark.parametrize(("membership", "files", "n"), QUOTAS)
def test_threads_follow_affinity_and_quota(tmp_path, monkeypatch, membership, files, n):
    groups(tmp_path, monkeypatch, membership, files)
    assert machine.usable_processors() == n


MEMORIES = [
    ("0::/job\n", {}, 64e9 * 1.024, "free on this machine"),
    ("0::/job\n", {"job/memory.max": "max\n", "job/memory.current": "1\n", "job/memory.stat": ""}, 65.536e9, "free"),
    ("0::/job\n",
     {"job/memory.max": "5000\n", "job/memory.current": "3000\n", "job/memory.stat": "inactive_file 500\n"},
     2500.0, "left to its control group"),
    (V1, {"memory/job/1/memory.limit_in_bytes": "5000\n", "memory/job/1/memory.usage_in_bytes": "3000\n",
          "memory/job/1/memory.stat": "inactive_file 7\ntotal_inactive_file 500\n"}, 2500.0, "left to its"),
]  # fmt: skip


@pytest.mark.parametrize(("membership", "files", "n_bytes", "source"), MEMORIES)
def test_memory_is_what_machine_and_control_group_leave(tmp_path, monkeypatch, membership, files, n_bytes, source):
    groups(tmp_path, monkeypatch, membership, files)
    found = machine.available_memory()
    assert found.n_bytes == pytest.approx(n_bytes)
    assert source in found.source


@pytest.mark.skipif(not hasattr(os, "sched_setaffinity"), reason="no affinity on this system")
def test_a_job_on_one_processor_runs_and_searches_on_one_thread(monkeypatch):
    before, asked = os.sched_getaffinity(0), []
    from porous_swim.obstacles import cells

    class Tree(cells.cKDTree):
        def query_ball_point(self, *arguments, workers, **options):
            asked.append(workers)
            return super().query_ball_point(*arguments, workers=workers, **options)

    monkeypatch.setattr(cells, "cKDTree", Tree)
    scene = ps.load_scene("scenes/crystal.yaml").replace(
        {"swimmers.count": 20, "run.duration": 0.1, "record.every": 0.1}
    )
    os.sched_setaffinity(0, {min(before)})
    try:
        build_cells(scene.place_obstacles(), reach=1.5)
        assert ps.run(scene).summary["provenance"]["threads"] == 1
    finally:
        os.sched_setaffinity(0, before)
    assert set(asked) == {1}
    asked.clear()
    assert ps.run(scene.replace({"run.threads": 2})).summary["provenance"]["threads"] == 2
    assert set(asked) == {2}


def start(scene: Scene) -> int:
    return len(ps.run(scene).colloids)


def test_a_process_forked_after_a_run_is_told_what_to_do_and_ends():
    simulation = ps.Simulation(Scene.from_mapping(SCENE))
    child = os.fork()
    if child == 0:
        code = 0
        calls = [lambda: start(simulation.scene), lambda: simulation.advance(1), lambda: simulation.frame()]
        for call in calls:
            try:
                call()
                code = 1
            except DeviceError as error:
                code |= 0 if "multiprocessing.get_context('spawn')" in str(error) else 2
        os._exit(code)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0
    simulation.advance(1)  # the parent goes on


def test_a_forked_process_that_ends_as_programs_do_ends(tmp_path):
    program = (
        "import os, porous_swim as ps\n"
        f"ps.run(ps.Scene.from_mapping({SCENE!r}))\n"
        "child = os.fork()\n"
        "if child: raise SystemExit(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))\n"
    )
    assert subprocess.run([sys.executable, "-c", program], env=environment(), timeout=120).returncode == 0


@pytest.mark.parametrize("method", ["spawn", "forkserver"])
def test_workers_that_are_started_anew_run_after_a_run(method):
    scene = Scene.from_mapping(SCENE)
    start(scene)
    with multiprocessing.get_context(method).Pool(1) as pool:
        assert pool.map_async(start, [scene]).get(timeout=120) == [1]


def command(*prefix: str, cwd: Path, **variables: str | None) -> subprocess.CompletedProcess[str]:
    """A run of a small scene behind `prefix`; a variable that is None is not set."""
    values = environment(**{name: value for name, value in variables.items() if value is not None})
    values = {name: value for name, value in values.items() if variables.get(name, "") is not None}
    run = [sys.executable, "-m", "porous_swim", "run", str(small_scene(cwd)), "--quiet", "--threads", "1"]
    return subprocess.run([*prefix, *run], cwd=cwd, env=values, capture_output=True, text=True, timeout=300)


SHELL = {
    "n 8": "only 8 files may be open at once (ulimit -n)",
    "v 500000": "GB of address space are left (ulimit -v)",
    "v 4000000": "GB of address space are left (ulimit -v)",
}


@pytest.mark.skipif(sys.platform != "linux", reason="limits as Linux sets them")
@pytest.mark.parametrize("limit", SHELL)
def test_a_low_limit_is_a_sentence(tmp_path, limit):
    done = command("bash", "-c", f'ulimit -{limit}; exec "$@"', "-", cwd=tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.count("\n") == 1
    assert SHELL[limit] in done.stderr


def test_few_threads_are_a_sentence(monkeypatch):
    class Thread:
        left = 3

        def __init__(self, **options: object) -> None: ...

        def start(self) -> None:
            Thread.left -= 1
            if Thread.left < 0:
                raise RuntimeError("can't start new thread")

        def join(self) -> None: ...

    monkeypatch.setattr("threading.Thread", Thread)
    with pytest.raises(DeviceError, match=r"only 3 more threads can be started .* up to 18 are needed"):
        limits.require(address=0.0, threads=18)


def home(kind: str, folder: Path) -> str | None:
    """A home in which Taichi cannot keep anything."""
    if kind == "file":
        (folder / ".cache").mkdir()
        (folder / ".cache/taichi").write_text("")
    elif kind == "read-only":
        folder.chmod(0o555)
    return {"unset": None, "nonexistent": "/nonexistent/home"}.get(kind, str(folder))


@pytest.mark.skipif(sys.platform != "linux", reason="homes and rights as Linux has them")
@pytest.mark.parametrize("kind", ["unset", "nonexistent", "read-only", "file"])
def test_a_run_without_a_home_to_write_to_says_so_once_and_leaves_nothing_behind(tmp_path, kind):
    (tmp_path / "home").mkdir()
    (tmp_path / "tmp").mkdir()
    prefix = []
    if os.geteuid() == 0 and kind == "nonexistent":
        pytest.skip("root can make it")
    if os.geteuid() == 0 and kind == "read-only":  # who may write anywhere must give that up
        if shutil.which("setpriv") is None:
            pytest.skip("there is no setpriv")
        prefix = ["setpriv", "--bounding-set=-dac_override,-dac_read_search"]
    done = command(
        *prefix, cwd=tmp_path, HOME=home(kind, tmp_path / "home"), XDG_CACHE_HOME=None, TMPDIR=str(tmp_path / "tmp")
    )
    (tmp_path / "home").chmod(0o755)
    assert (done.returncode, done.stderr.count("\n")) == (0, 1)
    assert done.stderr.startswith("warning: compiled kernels cannot be kept, as ")
    assert (tmp_path / done.stdout.strip() / "summary.json").is_file()
    assert list((tmp_path / "tmp").iterdir()) == []


def test_a_device_that_runs_says_its_threads():
    assert backend.ensure("cpu").threads == machine.usable_processors()
