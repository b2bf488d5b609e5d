"""The folder in which Taichi keeps compiled kernels. Where it cannot be used, Taichi aborts, or dies at the exit."""

from __future__ import annotations

import atexit
import os
import shutil
import sys
import tempfile
from pathlib import Path

VARIABLE = "XDG_CACHE_HOME"  # which Taichi, too, takes before $HOME/.cache
_faults: list[str] = []
_told: list[str] = []


def prepare() -> None:
    """Show Taichi a temporary folder, removed at the exit, where its own cannot be used.

    To be called before Taichi is loaded; does nothing afterwards.
    """
    if "taichi" in sys.modules:
        return
    fault = _fault(os.environ)
    if fault is None:
        return
    try:
        folder = tempfile.mkdtemp(prefix="porous_swim-")
    except OSError:
        return  # nowhere to write: Taichi will say so in its way
    os.environ[VARIABLE] = folder  # workers that this process starts take it, too
    os.environ.setdefault("TI_SKIP_VERSION_CHECK", "ON")  # else a thread of Taichi's looks for news to write there
    atexit.register(_remove, folder, os.getpid())
    _faults.append(fault)


def keeps() -> bool:
    """Whether compiled kernels are worth keeping."""
    return not _faults


def doubts() -> list[str]:
    """Sentences about the folder that have not been asked for yet."""
    fresh = _faults[len(_told) :]
    _told.extend(fresh)
    return [
        f"warning: compiled kernels cannot be kept, as {fault}, so each start compiles them anew: set {VARIABLE} to a "
        "folder that can be written"
        for fault in fresh
    ]


def _fault(environment: os._Environ[str] | dict[str, str]) -> str | None:
    """Why Taichi's own folder cannot be used; None where it can."""
    if VARIABLE in environment:
        base = environment[VARIABLE]
    elif "HOME" in environment:
        base = environment["HOME"] + "/.cache"
    else:
        return "HOME is not set"
    folder = Path(f"{base}/taichi/ticache")
    for part in (folder, *folder.parents):
        if os.path.lexists(part):  # the first that is there must be a folder to write to
            if not part.is_dir():
                return f"{part} is no folder"
            break
    if not os.access(part, os.W_OK | os.X_OK):
        return f"{part} cannot be written"
    for name in ("ticache.tcb", "ticache.lock"):
        if os.path.lexists(folder / name) and not os.access(folder / name, os.R_OK | os.W_OK):
            return f"{folder / name} cannot be written"
    return None


def _remove(folder: str, owner: int) -> None:
    if os.getpid() == owner:  # a process that was forked leaves it alone
        if "taichi" in sys.modules:  # which makes the folder once more when it ends: let it end now
            sys.modules["taichi"].reset()
        shutil.rmtree(folder, ignore_errors=True)
