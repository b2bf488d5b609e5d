"""Ctrl-C, SIGTERM and SIGHUP: the first one lets a run end cleanly, a second Ctrl-C or SIGTERM ends it at once."""

from __future__ import annotations

import ctypes
import signal
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any

HANGUP = getattr(signal, "SIGHUP", None)  # the terminal or the connection is lost; Windows has none
SIGNALS = (signal.SIGINT, signal.SIGTERM, *(() if HANGUP is None else (HANGUP,)))


@contextmanager
def fatal() -> Iterator[None]:
    """Ctrl-C ends the process at once: libraries that are being loaded may swallow a `KeyboardInterrupt`."""
    try:
        before = signal.signal(signal.SIGINT, signal.SIG_DFL)
    except ValueError:  # not in the main thread
        yield
        return
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


class Interrupts:
    """A context in which the first signal is only noted: true once there was one."""

    def __init__(self) -> None:
        self._seen: signal.Signals | None = None
        self._before: dict[signal.Signals, Any] = {}

    def __bool__(self) -> bool:
        return self._seen is not None

    @property
    def name(self) -> str | None:
        """The first signal, such as SIGTERM; None where there was none."""
        return None if self._seen is None else self._seen.name

    def __enter__(self) -> Interrupts:
        try:
            for number in SIGNALS:
                if number != HANGUP or signal.getsignal(number) is not signal.SIG_IGN:  # as nohup leaves it
                    self._before[number] = signal.signal(number, self._note)
        except ValueError:  # not in the main thread, which alone may handle signals
            self._before = {}
        return self

    def __exit__(self, *_: object) -> None:
        for number, handler in self._before.items():
            signal.signal(number, handler)

    @contextmanager
    def while_compiling(self) -> Iterator[None]:
        """The same where Python cannot run a handler: Taichi compiles for seconds without letting go of it."""
        if self._before:
            _make_one_shot(number for number in self._before if number != HANGUP)
        try:
            yield
        finally:
            for number in self._before:
                signal.signal(number, self._note)

    def _note(self, number: int, _frame: FrameType | None) -> None:
        if self._seen is None:
            self._seen = signal.Signals(number)
        elif number != HANGUP:  # a lost connection may be told twice, by the terminal and by the shell
            raise KeyboardInterrupt(number)


def exit_status(name: str) -> int:
    """What shells say of a process that the signal of this name ends."""
    return 128 + signal.Signals[name]


def _make_one_shot(numbers: Iterable[signal.Signals]) -> None:
    """Have the C library forget Python's handlers after one signal each, so that the next one kills.

    The `signal` module cannot ask for that (SA_RESETHAND). Without glibc the second signal, too, waits for the
    compiler.
    """
    libc = ctypes.CDLL(None)
    if not hasattr(libc, "sysv_signal"):
        return
    for function in (libc.signal, libc.sysv_signal):
        function.argtypes, function.restype = [ctypes.c_int, ctypes.c_void_p], ctypes.c_void_p
    for number in numbers:
        libc.sysv_signal(number, libc.signal(number, None))
