"""The command line as a user meets it: exit statuses, what is printed where, and what is left on disk."""

from __future__ import annotations

import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from rerun.chunk import RrdReader

import porous_swim as ps
from porous_swim.commands import cli
from porous_swim.engine.backend import available
from tests.support.commands import NO_END, SCENES, environment, porous_swim, small_scene, start

RUN_FILES = {
    "scene.yaml", "recording.rrd", "colloids.parquet", "encounters.parquet", "timeseries.parquet",
    "lags.parquet", "trajectory.parquet", "summary.json",
}  # fmt: skip
# The command line with a drift that single precision cannot hold, which no scene may ask for: the first step is not a
# number.
TOO_STRONG = """
import numpy as np
from porous_swim.commands import cli
from porous_swim.running import simulation
dynamics_of = simulation.dynamics_of
def too_strong(scenes):
    found = dynamics_of(scenes)
    found.parameters.table[:] *= np.where(np.array(found.parameters.names) == "alpha", 1e35, 1.0)
    return found
simulation.dynamics_of = too_strong
cli.main()
"""


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    return small_scene(tmp_path)


@pytest.fixture
def failed(monkeypatch, capsys, tmp_path):
    """Call the command line here, for a command that must fail with status 2, and return its one sentence."""

    def call(*arguments: object) -> str:
        before = sorted(tmp_path.rglob("*"))
        monkeypatch.chdir(tmp_path)
        monkeypatch.setattr(sys, "argv", ["porous-swim", *map(str, arguments)])
        with pytest.raises(SystemExit) as left:
            cli.main()
        printed = capsys.readouterr()
        assert left.value.code == 2
        assert printed.out == ""
        assert len(printed.err.splitlines()) == 1
        assert sorted(tmp_path.rglob("*")) == before
        return printed.err

    return call


def test_a_run_ends_with_its_folder_and_a_second_one_takes_the_next_name(scene, tmp_path):
    first, second = (porous_swim("run", scene, cwd=tmp_path) for _ in range(2))
    assert (first.returncode, second.returncode) == (0, 0), first.stderr
    assert first.stdout.splitlines()[-1] == "runs/small"
    assert second.stdout.splitlines()[-1] == "runs/small-2"
    assert {path.name for path in (tmp_path / "runs/small").iterdir()} == RUN_FILES
    assert "fraction bound" in first.stdout
    assert "compiling" in first.stderr
    assert "swimming" in first.stderr.splitlines()[-1]
    assert json.loads((tmp_path / "runs/small/summary.json").read_text())["status"] == "finished"


def test_a_quiet_run_prints_its_folder_and_nothing_else(scene, tmp_path):
    result = porous_swim("run", scene, "--quiet", "--out", "mine", "--no-recording", cwd=tmp_path)
    assert (result.returncode, result.stdout, result.stderr) == (0, "mine\n", "")
    assert {path.name for path in (tmp_path / "mine").iterdir()} == RUN_FILES - {"recording.rrd"}


def test_a_folder_in_use_is_kept_unless_forced(scene, failed, tmp_path):
    porous_swim("run", scene, "--quiet", "--out", "mine", "--seed", 5, cwd=tmp_path)
    before = (tmp_path / "mine/summary.json").read_bytes()
    assert "--force" in failed("run", scene, "--out", "mine")
    assert "blue" in failed("run", scene, "--out", "mine", "--force", "--set", "run.device=blue")
    failed("run", scene, "--out", "mine", "--force", "--set", "swimmers.release={kind: point, position: [0, 0]}")
    assert (tmp_path / "mine/summary.json").read_bytes() == before
    porous_swim("report", "mine", cwd=tmp_path)
    assert porous_swim("run", scene, "--quiet", "--out", "mine", "--force", cwd=tmp_path).returncode == 0
    assert not (tmp_path / "mine/report").exists()
    assert json.loads((tmp_path / "mine/summary.json").read_text())["provenance"]["seed"] == 1


@pytest.mark.parametrize(
    ("arguments", "names"),
    [
        (("run", "none.yaml"), "none.yaml"),
        (("run", "."), "."),
        (("check", "none.yaml"), "none.yaml"),
        (("run", "small.yaml", "--set", "swimmers.dipole_strenght=1"), "dipole_strength"),
        (("run", "small.yaml", "--set", "swimmers.dipole_strength"), "KEY=VALUE"),
        (("run", "small.yaml", "--set", "obstacles.cells=[2"), "--set obstacles.cells=[2"),
        (("run", "small.yaml", "--set", "obstacles.radius=6"), "obstacles"),
        (("run", "small.yaml", "--precision", "f16"), "run.precision"),
        (("run", "small.yaml", "--threads", "0"), "run.threads"),
        (("check", "small.yaml", "--set", "swimmers.release={kind: point, position: [0, 0]}"), "swimmers.release"),
        (("run", "small.yaml", "--out", "small.yaml/in"), "small.yaml/in"),
        (("view", "."), "recording.rrd"),
        (("new", "mine", "--from", "cristal"), "did you mean crystal?"),
        (("new", "small.yaml"), "exists already"),
        (("new", "no/folder"), "no/folder.yaml"),
        (("new", "my scene"), "my scene"),
    ],
)
def test_a_mistake_of_the_user_is_one_sentence_with_status_2(arguments, names, scene, failed):
    assert names in failed(*arguments)


@pytest.mark.parametrize("device", ["cuda", "metal"])
def test_an_absent_device_is_named_and_the_present_ones_too(device, scene, failed):
    if available(device):
        pytest.skip(f"this machine has {device}")
    message = failed("run", scene, "--device", device)
    assert device in message
    assert "cpu" in message


def test_auto_says_that_it_fell_back_to_the_cpu(scene, tmp_path):
    if available("cuda") or available("metal"):
        pytest.skip("auto finds a GPU here")
    lines = porous_swim("run", scene, "--no-recording", cwd=tmp_path).stderr.splitlines()
    assert "CPU" in lines[0]
    assert "no CUDA or Metal" in lines[0]
    asked = porous_swim("run", scene, "--no-recording", "--device", "cpu", cwd=tmp_path).stderr.splitlines()
    assert "no CUDA" not in asked[0]


def test_the_list_of_commands_says_whole_sentences(tmp_path):
    listed = porous_swim("--help", cwd=tmp_path).stdout.partition("Commands:")[2].splitlines()[1:]
    assert len(listed) == 9
    assert all(line.endswith(".") and not line.endswith("...") for line in listed)


def test_an_unknown_option_is_answered_with_the_usage(tmp_path):
    result = porous_swim("run", "--colour", cwd=tmp_path)
    assert result.returncode == 2
    assert "--colour" in result.stderr
    assert "Traceback" not in result.stderr


@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_an_interrupted_run_is_readable_and_says_so(number, scene, tmp_path):
    child = start("run", scene, *NO_END, cwd=tmp_path)
    _wait_for(tmp_path / "runs/small/recording.rrd.part")
    time.sleep(0.5)
    child.send_signal(number)
    stdout, stderr = child.communicate(timeout=60)
    assert child.returncode == 128 + number, stderr
    assert stdout.splitlines()[-1] == "runs/small"
    assert "interrupted at time" in stderr.splitlines()[-1]
    assert "Traceback" not in stderr
    assert {path.name for path in (tmp_path / "runs/small").iterdir()} == RUN_FILES
    results = ps.load_results(tmp_path / "runs/small")
    assert (results.summary["status"], results.summary["signal"]) == ("interrupted", number.name)
    last = results.timeseries["time"].to_numpy()[-1]
    assert results.info.last_time == last > 0.0
    assert results.trajectory["time"].to_numpy()[-1] == last
    assert np.all(results.encounters["end_time"].to_numpy() <= last)
    recording = tmp_path / "runs/small/recording.rrd"
    RrdReader(recording).store()
    text = subprocess.run([sys.executable, "-m", "rerun", "rrd", "print", "-vvv", recording], capture_output=True)
    assert b"Interrupted" in text.stdout


@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
def test_an_interrupt_while_libraries_load_is_not_swallowed_by_them():
    swallow = """
import os, signal
from porous_swim.running.interrupts import fatal
with fatal():
    try:
        os.kill(os.getpid(), signal.SIGINT)
        sum(range(1000))
    except BaseException:
        pass
print("went on")
"""
    done = subprocess.run([sys.executable, "-c", swallow], env=environment(), capture_output=True, text=True)
    assert (done.returncode, done.stdout, done.stderr) == (-signal.SIGINT, "", "")  # a shell says 130


@pytest.mark.skipif(sys.platform != "linux", reason="needs glibc's one-shot handlers")
def test_a_second_interrupt_ends_a_compiling_run_at_once(scene, tmp_path):
    # an empty cache: the kernel compiles for ten seconds or more, with Python at a stand
    child = start("run", scene, cwd=tmp_path, TI_OFFLINE_CACHE_FILE_PATH=tmp_path / "cache")
    assert "compiling" in child.stderr.readline()
    time.sleep(3.0)
    child.send_signal(signal.SIGINT)
    time.sleep(0.5)
    child.send_signal(signal.SIGINT)
    begin = time.monotonic()
    _, stderr = child.communicate(timeout=60)
    assert time.monotonic() - begin < 3.0
    assert child.returncode in (-signal.SIGINT, 130)  # a shell says 130 for both
    assert "Traceback" not in stderr
    assert not (tmp_path / "runs/small/summary.json").exists()


@pytest.mark.slow
def test_an_interrupt_while_compiling_leaves_a_run_of_no_length(scene, tmp_path):
    child = start("run", scene, *NO_END, cwd=tmp_path, TI_OFFLINE_CACHE_FILE_PATH=tmp_path / "cache")
    assert "compiling" in child.stderr.readline()
    time.sleep(3.0)
    child.send_signal(signal.SIGINT)
    stdout, _ = child.communicate(timeout=200)
    assert child.returncode == 130
    results = ps.load_results(tmp_path / stdout.splitlines()[-1])
    assert results.summary["status"] == "interrupted"
    assert results.info.last_time == 0.0


def test_a_swimmer_that_cannot_go_on_is_named_and_what_was_seen_is_kept(tmp_path):
    command = [sys.executable, "-c", TOO_STRONG, "run", str(small_scene(tmp_path))]
    result = subprocess.run(command, cwd=tmp_path, env=environment(), capture_output=True, text=True, timeout=300)
    assert result.returncode == 1, result.stdout
    sentence = result.stderr.splitlines()[-1]
    assert "Traceback" not in result.stderr
    for words in ("swimmer ", "(time ", "near (", "time step"):
        assert words in sentence
    results = ps.load_results(tmp_path / "runs/small")
    assert results.summary["status"] == "failed"
    assert any(sentence in warning for warning in results.summary["warnings"])
    assert results.timeseries.num_rows >= 1
    assert results.trajectory.num_rows == 20 * results.timeseries.num_rows
    RrdReader(tmp_path / "runs/small/recording.rrd").store()


@pytest.mark.skipif(os.name != "posix", reason="limits the size of files as POSIX does")
@pytest.mark.parametrize("recording", [True, False])
def test_a_full_disk_is_one_sentence_with_status_1(recording, scene, tmp_path):
    import resource

    def limit() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, 100_000))

    options = ["--set", "record.every=0.001", "--set", "record.swimmers=40", *(() if recording else ["--no-recording"])]
    arguments = ["run", scene, "--quiet", *options]
    result = porous_swim(*arguments, "--out", "full", cwd=tmp_path, preexec_fn=limit)
    assert result.returncode == 1, result.stderr
    sentence = result.stderr.splitlines()[-1]
    assert sentence.startswith(f"{tmp_path}/full/"), result.stderr
    assert "Traceback" not in result.stderr  # Rerun may have logged lines of its own
    results = ps.load_results(tmp_path / "full")
    assert results.summary["status"] == "failed"
    assert set(results.summary["missing"]) == {"trajectory.parquet", *(["recording.rrd"] if recording else [])}
    assert results.timeseries.num_rows == 1001
    assert results.encounters.num_rows > 0


def test_check_names_counts_numbers_and_warnings_without_running(tmp_path):
    thermal = next(path for path in SCENES if path.stem == "crystal_thermal")
    result = porous_swim("check", thermal, "--set", "swimmers.dipole_strength=0.8", cwd=tmp_path)
    assert result.returncode == 0, result.stderr
    # D = kT/(6 pi mu a) = 0.2454 um^2/s, over a U = 5 um^2/s; A_c of the full equations for alpha = 0.8 is 15.061;
    # a hexagonal crystal covers pi A^2/(s^2 sqrt(3)/2) of the plane: 0.4444
    for words in ("2,000 pushers", "288 colloids", "0.4444", "D = 0.04907", "15.06", "a/U = 0.2 s", "warning"):
        assert words in result.stdout
    assert list(tmp_path.iterdir()) == []


def test_check_says_the_same_as_numbers(tmp_path):
    thermal = next(path for path in SCENES if path.stem == "crystal_thermal")
    found = json.loads(porous_swim("check", thermal, "--json", cwd=tmp_path).stdout)
    # as above: D = 0.2454 um^2/s over a U = 5 um^2/s, D_r = 3 D/4, the cover of a hexagonal crystal
    assert found["noise"]["translational_diffusion"] == pytest.approx(0.2454 / 5.0, abs=1e-5)
    assert found["noise"]["rotational_diffusion"] == pytest.approx(0.75 * 0.2454 / 5.0, abs=1e-5)
    cover = np.pi * 3.5**2 / (100.0 * np.sqrt(3.0) / 2.0)
    assert found["colloids"]["packing_fraction"] == pytest.approx(cover, rel=1e-12)
    assert (found["swimmers"]["count"], found["colloids"]["count"], found["run"]["n_steps"]) == (2000, 288, 30_000)
    assert found["units"] == {"length_um": 1.0, "time_s": 0.2}
    assert len(found["warnings"]) == 1
    assert found["scene_id"] == ps.load_scene(thermal).scene_id
    wall = porous_swim("check", thermal.with_name("wall.yaml"), "--json", cwd=tmp_path)
    assert json.loads(wall.stdout)["colloids"]["radius"] is None  # JSON has no infinity


def test_a_run_says_its_folder_and_summary_to_machines(scene, tmp_path):
    result = porous_swim("run", scene, "--json", "--out", "mine", "--no-recording", cwd=tmp_path)
    assert result.returncode == 0, result.stderr
    summary = json.loads((tmp_path / "mine/summary.json").read_text())
    assert json.loads(result.stdout) == {"folder": "mine"} | summary
    assert "swimming" in result.stderr  # progress goes elsewhere


def test_the_version_is_said_by_the_command_and_the_module(tmp_path):
    result = porous_swim("--version", cwd=tmp_path)
    assert (result.returncode, result.stdout) == (0, f"porous-swim {ps.__version__}\n")


def test_a_template_runs_where_it_is_written(tmp_path):
    made = porous_swim("new", "mine", "--from", "beads", cwd=tmp_path)
    assert made.stdout == "mine.yaml\n"
    assert (tmp_path / "mine.yaml").read_text().count("name: mine") == 1
    result = porous_swim("run", "mine.yaml", "--quiet", "--set", "run.duration=0.5", cwd=tmp_path)
    assert result.stdout == "runs/mine\n", result.stderr


def test_the_schema_is_json_and_names_the_sections(tmp_path):
    schema = json.loads(porous_swim("schema", cwd=tmp_path).stdout)
    assert {"swimmers", "obstacles", "noise", "run", "record"} <= set(schema["properties"])


@pytest.fixture
def unread():
    """A pipe whose reader has gone, as after `| head -1`."""
    reader, writer = os.pipe()
    os.close(reader)
    yield writer
    os.close(writer)


@pytest.mark.skipif(os.name != "posix", reason="pipes of POSIX")
@pytest.mark.parametrize(
    "arguments", [("schema",), ("--help",), ("check", "small.yaml"), ("theory", "--dipole-strength", 1)]
)
def test_output_that_nobody_reads_ends_quietly_as_other_tools_do(arguments, scene, unread, tmp_path):
    child = start(*arguments, cwd=tmp_path, stdout=unread)
    _, stderr = child.communicate(timeout=60)
    assert (child.returncode, stderr) == (128 + signal.SIGPIPE, "")


@pytest.mark.skipif(os.name != "posix", reason="pipes of POSIX")
def test_a_run_whose_progress_nobody_reads_goes_on_to_its_end(scene, unread, tmp_path):
    child = start("run", scene, cwd=tmp_path, stdout=unread, stderr=unread)
    child.wait(timeout=300)
    assert child.returncode == 128 + signal.SIGPIPE
    assert ps.load_results(tmp_path / "runs/small").summary["status"] == "finished"


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="needs a device that is full")
@pytest.mark.parametrize("command", ["schema", "--help"])  # more and less than a buffer
def test_output_that_cannot_be_written_is_one_sentence(command, tmp_path):
    with open("/dev/full", "w") as full:
        child = start(command, cwd=tmp_path, stdout=full)
        _, stderr = child.communicate(timeout=60)
    assert (child.returncode, stderr) == (1, "output: No space left on device\n")


@pytest.mark.parametrize("web", [False, True])
def test_view_becomes_the_rerun_viewer_of_the_recording(web, tmp_path, monkeypatch):
    (tmp_path / "recording.rrd").touch()
    seen: list[list[str]] = []
    monkeypatch.setattr(os, "execve", lambda _, command, environment: seen.append(command))
    monkeypatch.setenv("DISPLAY", ":0")
    cli.view(tmp_path, web=web)
    assert seen[0][1:4] == ["-m", "rerun", str(tmp_path / "recording.rrd")]
    assert ("--web-viewer" in seen[0]) == web


@pytest.mark.skipif(shutil.which("strace") is None, reason="strace tells who is connected to")
def test_the_process_of_a_viewer_that_was_started_before_connects_to_this_machine_alone(tmp_path):
    # Rerun's statistics begin with the second start, with a look-up of their server's name
    scene = small_scene(tmp_path)
    assert porous_swim("run", scene, "--out", tmp_path / "run", cwd=tmp_path).returncode == 0
    settings = {"HOME": str(tmp_path), "XDG_CONFIG_HOME": str(tmp_path), "XDG_DATA_HOME": str(tmp_path)}
    there = {name: value for name, value in environment().items() if name not in {"CI", "BROWSER"}}
    trace = ["strace", "-f", "-e", "trace=connect", "-e", "signal=none"]
    for i in range(2):
        log = tmp_path / f"trace{i}"
        child = subprocess.Popen(
            [*trace, "-o", log, sys.executable, "-m", "porous_swim", "view", "--web", tmp_path / "run"],
            env=there | settings | {"BROWSER": "true"}, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
            start_new_session=True,
        )  # fmt: skip
        time.sleep(6.0)
        os.killpg(child.pid, signal.SIGKILL)
        child.wait()
        peers = set(re.findall(r'inet_addr\("([^"]*)"\)', log.read_text()))
        assert peers <= {"127.0.0.1"}


@pytest.mark.skipif(sys.platform != "linux", reason="displays of other systems have no name")
def test_view_without_a_display_says_so(tmp_path, monkeypatch):
    (tmp_path / "recording.rrd").touch()
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    with pytest.raises(ps.ResultsError, match="no display here; --web opens"):
        cli.view(tmp_path)


def _wait_for(path: Path, seconds: float = 120.0) -> None:
    """Wait until a file is there."""
    end = time.monotonic() + seconds
    while not path.exists():
        assert time.monotonic() < end, f"{path} did not come"
        time.sleep(0.1)
