"""Picture of a recording in Rerun's viewer in a browser: `python tools/web_screenshot.py RECORDING PICTURE.png`.

Needs Chromium (Debian: `apt-get install chromium`), which draws in software and reaches nothing but this machine.
"""

from __future__ import annotations

import argparse
import base64
import contextlib
import itertools
import json
import os
import shutil
import socket
import subprocess
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import rerun_cli

_OPTIONS = (
    "--headless=new", "--no-sandbox", "--remote-debugging-pipe", "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist", "--no-first-run", "--disable-background-networking",
    "--disable-component-update", "--disable-sync", "--host-resolver-rules=MAP * ~NOTFOUND , EXCLUDE 127.0.0.1",
)  # fmt: skip


def main() -> None:
    """Read the command line, take the picture."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("recording", type=Path)
    parser.add_argument("picture", type=Path)
    parser.add_argument("--wait", type=float, default=40.0, help="seconds until the picture; software draws slowly")
    options = parser.parse_args()
    with web_viewer(options.recording) as page:
        time.sleep(options.wait)
        options.picture.write_bytes(page.screenshot())


def chromium() -> str | None:
    """The browser, where there is one."""
    return shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")


class Page:
    """One page of a browser that is spoken to through pipes: messages of JSON, each ended by a zero byte."""

    def __init__(self, commands: int, answers: int) -> None:
        self._commands, self._answers = os.fdopen(commands, "wb"), os.fdopen(answers, "rb")
        self._number, self._session = itertools.count(1), {}
        targets = self._call("Target.getTargets")["targetInfos"]
        page = next(target["targetId"] for target in targets if target["type"] == "page")
        attached = self._call("Target.attachToTarget", targetId=page, flatten=True)
        self._session = {"sessionId": attached["sessionId"]}

    def screenshot(self) -> bytes:
        """What is on the screen, as PNG."""
        return base64.b64decode(self._call("Page.captureScreenshot", format="png")["data"])

    def _call(self, method: str, **parameters: object) -> dict[str, Any]:
        number = next(self._number)
        message = {"id": number, "method": method, "params": parameters, **self._session}
        self._commands.write(json.dumps(message).encode() + b"\0")
        self._commands.flush()
        while (answer := self._read()).get("id") != number:  # events
            pass
        return answer["result"]

    def _read(self) -> dict[str, Any]:
        text = bytearray()
        while (byte := self._answers.read(1)) != b"\0":
            if not byte:
                raise RuntimeError("the browser ended")
            text += byte
        return json.loads(text)


@contextlib.contextmanager
def web_viewer(recording: Path, *, size: str = "1400,900") -> Iterator[Page]:
    """The recording in a browser, as `porous-swim view --web` opens it."""
    browser = chromium()
    if browser is None:
        raise RuntimeError("there is no Chromium here")
    web, grpc = _free_port(), _free_port()
    server = [Path(rerun_cli.__file__).parent / "rerun", recording, "--serve-web", "--bind", "127.0.0.1",
              "--web-viewer-port", web, "--port", grpc]  # fmt: skip
    address = f"http://127.0.0.1:{web}/?url=rerun%2Bhttp%3A%2F%2F127.0.0.1%3A{grpc}%2Fproxy&renderer=webgl"
    child_reads, commands = os.pipe()
    answers, child_writes = os.pipe()

    def connect() -> None:  # the browser reads its commands from 3 and answers on 4
        os.dup2(child_reads, 10)
        os.dup2(child_writes, 11)
        os.dup2(10, 3)
        os.dup2(11, 4)

    with tempfile.TemporaryDirectory() as profile, contextlib.ExitStack() as stack:
        stack.enter_context(_running(list(map(str, server))))
        _wait_for(web)
        command = [browser, *_OPTIONS, f"--user-data-dir={profile}", f"--window-size={size}", address]
        stack.enter_context(_running(command, preexec_fn=connect, pass_fds=(3, 4)))
        os.close(child_reads)
        os.close(child_writes)
        yield Page(commands, answers)


@contextlib.contextmanager
def _running(command: list[str], **options: Any) -> Iterator[None]:
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, **options)
    try:
        yield
    finally:
        process.terminate()
        try:
            process.wait(10.0)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()


def _free_port() -> int:
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        return free.getsockname()[1]


def _wait_for(port: int, seconds: float = 30.0) -> None:
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        with contextlib.suppress(OSError), socket.create_connection(("127.0.0.1", port), timeout=1.0):
            return
        time.sleep(0.2)
    raise RuntimeError("the web viewer did not start")


if __name__ == "__main__":
    main()
