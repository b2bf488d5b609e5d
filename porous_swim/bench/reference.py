"""The reference in C: one noisy swimmer near one sphere after the other, or in blocks; built when it is needed.

Lengths in a, times in a/U. `swim.c` says what it does.
"""

from __future__ import annotations

import ctypes
import shutil
import subprocess
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from porous_swim.bench.job import OneColloid
from porous_swim.bench.timing import Work, fastest, take_turns

SOURCE = Path(__file__).with_name("swim.c")
FLAGS = ("-std=gnu11", "-O3", "-march=native", "-ffast-math", "-fopenmp-simd", "-shared", "-fPIC")
COMPILERS = {"clang": ("-fveclib=libmvec",), "gcc": ()}
NARROW = "-mno-avx512f"  # Taichi 1.7.4 emits no AVX-512: what C does in the vectors that Taichi has
BLOCKS = (8, 16, 32)
_REAL = {"f32": ("float", np.float32), "f64": ("double", np.float64)}


@dataclass(frozen=True)
class Build:
    """How the source is compiled."""

    compiler: str
    lanes: int  # swimmers to a block; 1: one swimmer at a time
    precision: str
    narrow: bool = False

    def compile(self, folder: Path) -> Reference | None:
        """The reference as a library in `folder`; None where this compiler cannot make it."""
        real, _ = _REAL[self.precision]
        library = folder / f"{self.compiler}-{self.lanes}-{self.precision}{'-narrow' if self.narrow else ''}.so"
        options = (*FLAGS, *COMPILERS[self.compiler], *([NARROW] if self.narrow else []))
        defines = (f"-DREAL={real}", f"-DLANES={self.lanes}")
        command = [self.compiler, *options, *defines, str(SOURCE), "-o", str(library), "-lm"]
        made = subprocess.run(command, check=False, capture_output=True)
        return Reference(self, library) if made.returncode == 0 else None


def compilers() -> dict[str, str]:
    """The C compilers that are here, with what they say of their version."""
    found = [name for name in COMPILERS if shutil.which(name)]
    said = {name: subprocess.run([name, "--version"], capture_output=True, text=True).stdout for name in found}
    return {name: text.partition("\n")[0] for name, text in said.items()}


class Reference:
    """A library made from `swim.c`. Calls leave Python's lock, so that threads run at once."""

    def __init__(self, build: Build, library: Path) -> None:
        self.build = build
        self.name = f"{build.compiler}, {'scalar' if build.lanes == 1 else f'blocks of {build.lanes}'}"
        _, self.real = _REAL[build.precision]
        self._number = ctypes.c_float if build.precision == "f32" else ctypes.c_double
        self._library = ctypes.CDLL(str(library))
        whole, array = ctypes.c_int64, ctypes.c_void_p
        self._library.advance.argtypes = [array, *[whole] * 5, array]
        self._library.passages.argtypes = [array, whole, whole, self._number, array, array]
        self._library.drift_of.argtypes = [array, array, whole, *[self._number] * 3, array, array]

    def advance(self, state: np.ndarray, part: slice, *, first: int, n_steps: int, job: OneColloid) -> None:
        """Move the swimmers `part` of `state` (6, n), contiguous, in place by `n_steps` after step `first`.

        The bounds of `part` are whole blocks.
        """
        begin, end, _ = part.indices(state.shape[1])
        assert state.dtype == self.real
        assert state.flags.c_contiguous
        assert begin % self.build.lanes == end % self.build.lanes == 0
        self._library.advance(state.ctypes.data, state.shape[1], begin, end - begin, first, n_steps, self._rules(job))

    def passages(self, n_swimmers: int, *, sine: float, job: OneColloid, begin: int = 0) -> np.ndarray:
        """First steps (n,) at whose ends the sine of the pitch exceeds `sine`, from contact with pitch 0.

        `begin` is the number of the first swimmer: each number has noise of its own.
        """
        start = np.array([0.0, 0.0, job.radius + 1.0, 1.0, 0.0, 0.0], self.real)
        passage = np.zeros(n_swimmers, np.int32)
        self._library.passages(start.ctypes.data, begin, n_swimmers, sine, passage.ctypes.data, self._rules(job))
        return passage

    def _rules(self, job: OneColloid) -> bytes:
        return np.array(job.rules, self.real).tobytes() + np.array([job.seed, 0], np.uint32).tobytes()

    def work(self, n_swimmers: int, n_steps: int) -> Work:
        """The job of one colloid, on one thread."""
        job = OneColloid()
        state, step = job.start(n_swimmers, self.build.precision), 0

        def work() -> int:
            nonlocal step
            self.advance(state, slice(None), first=step, n_steps=n_steps, job=job)
            step += n_steps
            return n_swimmers * n_steps

        return work

    def drift(
        self, offset: np.ndarray, director: np.ndarray, *, radius: float, dipole_strength: float, bretherton: float
    ) -> tuple[np.ndarray, np.ndarray]:
        """Flow in U and rate of the director in U/a, both (n, 3), at offsets (n, 3) in a from a sphere."""
        x, e = (np.ascontiguousarray(array, self.real) for array in (offset, director))
        flow, rate = np.zeros_like(x), np.zeros_like(x)
        numbers = (radius, dipole_strength, bretherton)
        self._library.drift_of(x.ctypes.data, e.ctypes.data, len(x), *numbers, flow.ctypes.data, rate.ctypes.data)
        return flow, rate


@dataclass(frozen=True)
class References:
    """The fastest builds here; None where there is none."""

    blocked: Reference | None = None
    scalar: Reference | None = None
    narrow: Reference | None = None  # blocked, without AVX-512

    @classmethod
    def build(cls, folder: Path, *, n_swimmers: int, n_steps: int, rounds: int) -> References:
        """Compile in single precision with each compiler that is here, and take the fastest of each kind."""

        def fastest_of(lanes: Iterable[int], *, narrow: bool = False) -> Reference | None:
            builds = [Build(name, width, "f32", narrow) for name in compilers() for width in lanes]
            made = {one.name: one for build in builds if (one := build.compile(folder)) is not None}
            if not made:
                return None
            works = {name: one.work(n_swimmers, n_steps) for name, one in made.items()}
            return made[fastest(take_turns(works, rounds))]

        return cls(fastest_of(BLOCKS), fastest_of((1,)), fastest_of(BLOCKS, narrow=True))
