"""The folder in which Taichi keeps compiled kernels. Where it cannot be used, Taichi aborts, or dies at the exit.

Taichi runs what it finds there without a look: a kernel under the name of another, or one that was cut short, ends the
process. Checksums of the files, in a list beside them, tell such before: compiling gives the same bytes each time.
"""

from __future__ import annotations

import atexit
import json
import os
import shutil
import sys
import tempfile
import zlib
from contextlib import suppress
from pathlib import Path

VARIABLE = "XDG_CACHE_HOME"  # which Taichi, too, takes before $HOME/.cache
SEALS = "porous_swim-checksums.json"  # beside Taichi's folder: its own is Taichi's to clean
_faults: list[str] = []
_told: list[str] = []
_used: list[Path] = []


def prepare() -> None:
    """Show Taichi a temporary folder, removed at the exit, where its own cannot be used.

    To be called before Taichi is loaded; does nothing afterwards.
    """
    if "taichi" in sys.modules:
        return
    fault = _fault(os.environ)
    if fault is None:
        atexit.register(
            _seal, os.getpid()
        )  # before Taichi registers its own, so that it runs after: all is written then
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


def warnings() -> list[str]:
    """Sentences about the folder that have not been asked for yet."""
    fresh = _faults[len(_told) :]
    _told.extend(fresh)
    return [
        f"warning: compiled kernels cannot be kept, as {fault}, so each start compiles them anew: set {VARIABLE} to a "
        "folder that can be written"
        for fault in fresh
    ]


def check() -> None:
    """Remove all kernels where one is not what was compiled; to be called before a device starts.

    Costs a second for each GB or so, of which Taichi keeps a tenth at most.
    """
    if _faults or "taichi" not in sys.modules:
        return
    folder = _folder(os.environ)
    if folder is None or folder in _used:
        return
    _used.append(folder)
    seals = _seals(folder)
    if any(name in seals and seals[name] != _checksum(folder / name) for name in _kernels(folder)):
        for name in (*_kernels(folder), "ticache.tcb"):
            with suppress(OSError):
                (folder / name).unlink()


def _seal(owner: int) -> None:
    """List the checksums of all kernels that are not listed yet."""
    for folder in _used if os.getpid() == owner else ():
        _end_taichi()  # which writes what it compiled
        known = _seals(folder)
        with suppress(OSError):
            seals = {name: known.get(name) or _checksum(folder / name) for name in _kernels(folder)}
            part = folder.parent / f"{SEALS}.{owner}"
            part.write_text(json.dumps(seals), encoding="utf-8")
            os.replace(part, folder.parent / SEALS)


def _seals(folder: Path) -> dict[str, str]:
    try:
        seals = json.loads((folder.parent / SEALS).read_bytes())
    except (OSError, ValueError, RecursionError):
        return {}
    return seals if isinstance(seals, dict) else {}


def _kernels(folder: Path) -> list[str]:
    try:
        return sorted(entry.name for entry in os.scandir(folder) if entry.name.endswith(".tic"))
    except OSError:
        return []


def _checksum(path: Path) -> str:
    """Size and CRC-32; empty where it cannot be read."""
    try:
        content = path.read_bytes()
    except OSError:
        return ""
    return f"{len(content)} {zlib.crc32(content):08x}"


def _folder(environment: os._Environ[str] | dict[str, str]) -> Path | None:
    """Taichi's folder; None where there is none to be known."""
    if VARIABLE in environment:
        base = environment[VARIABLE]
    elif "HOME" in environment:
        base = environment["HOME"] + "/.cache"
    else:
        return None
    return Path(f"{base}/taichi/ticache")


def _fault(environment: os._Environ[str] | dict[str, str]) -> str | None:
    """Why Taichi's own folder cannot be used; None where it can."""
    folder = _folder(environment)
    if folder is None:
        return "HOME is not set"
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
        _end_taichi()  # which makes the folder once more when it ends
        shutil.rmtree(folder, ignore_errors=True)


def _end_taichi() -> None:
    if "taichi" in sys.modules:
        sys.modules["taichi"].reset()
