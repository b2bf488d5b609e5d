"""The lock of a run folder, held for the life of a run: its death lets go of it, however it dies.

A file of JSON in the folder says who holds it, and is locked with `flock`. Linux carries such locks to the server of an
NFS; a file system that has none (`works` is False) keeps nobody out.
"""

from __future__ import annotations

import errno
import json
import os
import socket
from contextlib import suppress
from datetime import datetime
from pathlib import Path
from typing import Any

from porous_swim.core.errors import ResultsError

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None  # type: ignore[assignment]

LOCK = "run.lock"
_NO_LOCKS = {errno.ENOLCK, errno.ENOSYS, errno.EOPNOTSUPP, errno.EINVAL}


class RunLock:
    """The lock of one folder, taken. `before` is what an earlier run left in its file; None where there was none."""

    def __init__(self, folder: Path) -> None:
        """Take the lock. ResultsError names the run that holds it; OSError where the file cannot be made."""
        self.path = folder / LOCK
        while True:
            # kept open for as long as the run lives; no child that is executed inherits it
            self._file = open(os.open(self.path, os.O_RDWR | os.O_CREAT, 0o666), "r+b", buffering=0)  # noqa: SIM115
            try:
                self.works = _locked(self._file.fileno())
                if self._is_named():
                    break
            except BlockingIOError:
                holder = _holder(_content(self.path))
                self._file.close()
                raise ResultsError(
                    f"{folder}: a run is under way in this folder ({holder}); wait for its end or name another folder"
                ) from None
            self._file.close()  # the run that held it has just ended and taken the file away
        self.made = os.fstat(self._file.fileno()).st_size == 0
        self.before = None if self.made else _content(self.path)

    def write(self, **content: Any) -> None:
        """Say who holds the lock, and `content`."""
        begun = datetime.now().astimezone().isoformat(timespec="seconds")
        text = json.dumps({"pid": os.getpid(), "host": socket.gethostname(), "begun": begun, **content}) + "\n"
        self._file.seek(0)
        self._file.write(text.encode())
        self._file.truncate()

    def content(self) -> dict[str, Any]:
        """What the file says that is now in the folder."""
        return _content(self.path) or {}

    def release(self, *, remove: bool) -> None:
        """Let go of the lock; with `remove` the file goes too, unless it is another's by now."""
        if self._file.closed:
            return
        with suppress(OSError):
            if remove and self._is_named():
                self.path.unlink()
        self._file.close()

    def _is_named(self) -> bool:
        """Whether the file that is open is the one in the folder."""
        try:
            return os.path.samestat(os.fstat(self._file.fileno()), self.path.stat())
        except FileNotFoundError:
            return False


def who_ran(folder: Path) -> str | None:
    """Who holds or held the lock of a folder, for people; None where there is no such file."""
    content = _content(folder / LOCK)
    return None if content is None else _holder(content)


def _locked(number: int) -> bool:
    """Lock an open file; False where that cannot be, `BlockingIOError` where another holds the lock."""
    if fcntl is None:
        return False
    try:
        fcntl.flock(number, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        if error.errno in _NO_LOCKS:
            return False
        if error.errno == errno.EACCES:  # as some network file systems have it
            raise BlockingIOError from error
        raise
    return True


def _content(path: Path) -> dict[str, Any] | None:
    """What the file of a lock says, nothing where that cannot be read; None where there is no file."""
    try:
        content = json.loads(path.read_bytes())
    except FileNotFoundError:
        return None
    except (OSError, ValueError, RecursionError):
        return {}
    return content if isinstance(content, dict) else {}


def _holder(content: dict[str, Any] | None) -> str:
    if not content or not {"pid", "host", "begun"} <= set(content):
        return "of a process that is not known"
    return f"process {content['pid']} on {content['host']}, begun {content['begun']}"
