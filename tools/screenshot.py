"""Picture of a recording in Rerun's headless viewer: `python tools/screenshot.py RECORDING PICTURE.png`.

Needs a Vulkan driver, of which Mesa's in software (Debian: mesa-vulkan-drivers) will do; no window system.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import rerun_cli
from rerun.chunk import RrdReader
from rerun.experimental import ViewerClient

from porous_swim.observers.rerun.timeline import SECONDS, STEP

_LOAD_SECONDS = 120.0


def main() -> None:
    """Read the command line, take the picture."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("recording", type=Path)
    parser.add_argument("picture", type=Path)
    parser.add_argument("--time", type=float, help="step, or seconds where the scene has units; by default as it opens")
    parser.add_argument("--view", help="name of the one view to show; by default the whole window")
    parser.add_argument("--size", default="1400x900", help="of the window, in points; a point is two pixels")
    parser.add_argument("--wait", type=float, default=8.0, help="seconds to settle: messages fade, texts are set")
    options = parser.parse_args()
    screenshot(
        options.recording, options.picture, moment=options.time, view=options.view, size=options.size, wait=options.wait
    )


def screenshot(
    recording: Path, picture: Path, *, moment: float | None = None, view: str | None = None, size: str = "1400x900",
    wait: float = 8.0,
) -> None:  # fmt: skip
    """Take a picture; what a view complains of goes to stderr. For the arguments see the command line."""
    with _viewer(recording, size=size) as viewer:
        if moment is not None:
            _go_to(viewer, recording, moment)
        time.sleep(wait)
        views = {found.name: found for found in viewer.get_state().views}
        for found in views.values():
            for report in found.reports:
                print(f"{found.name}: {report.severity}: {report.summary}", file=sys.stderr)
        if view is not None and view not in views:
            sys.exit(f"{view!r} is no view of {recording}: use one of {', '.join(map(str, views))}")
        chosen = {} if view is None else {"view_id": views[view].view_id}
        viewer.save_screenshot(str(picture.resolve()), **chosen)


def _go_to(viewer: ViewerClient, recording: Path, moment: float) -> None:
    """Stop at a moment of the time line on show."""
    name = time_line(recording)
    where = {"sequence": round(moment)} if name == STEP else {"duration": moment}
    viewer.set_time(name, **where, play_state="paused")


def time_line(recording: Path) -> str:
    """The time line on show: seconds where the recording has them, else steps."""
    return SECONDS if f"'{SECONDS}'" in RrdReader(recording).store().summary() else STEP


@contextlib.contextmanager
def _viewer(recording: Path, *, size: str) -> Iterator[ViewerClient]:
    # the binary itself: ending its Python wrapper would leave the viewer running
    binary = Path(rerun_cli.__file__).parent / "rerun"
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    command = [
        binary,
        recording,
        "--headless",
        "--window-size",
        size,
        "--bind",
        "127.0.0.1",
        "--port",
        str(port),
    ]
    environment = {**os.environ, "TELEMETRY_ENABLED": "false", "RUST_LOG": "error"}
    environment.pop("DISPLAY", None)
    process = subprocess.Popen([*map(str, command), "--hide-welcome-screen"], env=environment)
    try:
        yield _connect(process, port=port)
    finally:
        process.terminate()
        try:
            process.wait(10.0)
        except subprocess.TimeoutExpired:
            process.kill()


def _connect(process: subprocess.Popen[bytes], *, port: int) -> ViewerClient:
    deadline = time.monotonic() + _LOAD_SECONDS
    while time.monotonic() < deadline:
        if process.poll() is not None:
            sys.exit("the viewer ended before it showed anything: is there a Vulkan driver?")
        with contextlib.suppress(Exception):  # not listening yet: the client has no error of its own for that
            viewer = ViewerClient.connect(f"rerun+http://127.0.0.1:{port}/proxy")
            state = viewer.get_state()
            if state.recordings and not state.loading:
                return viewer
        time.sleep(0.3)
    sys.exit(f"the recording was not loaded within {_LOAD_SECONDS:g} s")


if __name__ == "__main__":
    main()
