"""The time to an answer: the mean of T_theta to 1 %, against the paper's algorithm (Euler, clamp) in C.

T_theta is when the pitch of a swimmer that starts in contact with pitch 0 first exceeds 3 alpha/8. The total error is
sqrt(bias^2 + standard error^2), relative to the mean; each side takes the step and the number of swimmers that make it
cheapest. Swimmers in C stop where they pass; those of the engine go on to an end by which nearly all have passed.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from porous_swim.bench.figure import Conditions, Figure, Setting
from porous_swim.bench.job import OneColloid
from porous_swim.bench.reference import Reference
from porous_swim.bench.timing import Ratio, take_turns
from porous_swim.paper.noise import Case, mean_of, trapping_times
from porous_swim.paper.scan import paper_scene

SCALAR_SHARE = 32  # scalar C swims 1 in so many: with the steps of blocked C, the time of all is to scale
STEP = 0.32  # of `reflected`, a/U
BIAS = 0.005  # a bound on its relative bias at this step, with what is cut off at the end
TARGETS = {"scalar C": 100.0, "blocked C": 30.0}  # for the first question


@dataclass(frozen=True)
class Question:
    """A mean that is asked for, and what is known of it beforehand: docs/convergence.md."""

    case: Case
    limit: float  # mean of T_theta in the limit of short steps, a/U
    spread: float  # standard deviation of T_theta over its mean
    euler_bias: float  # relative bias over the square root of the step
    end: float  # of the engine's run, a/U: by then all but 1 in 1000 have passed

    @property
    def text(self) -> str:
        """For names of figures."""
        return f"({self.case.radius:g}, {self.case.alpha:g}, {self.case.D:g})"

    @property
    def sine(self) -> float:
        """Of the escape pitch."""
        return math.sin(0.375 * self.case.alpha)

    def swimmers(self, standard_error: float) -> int:
        """How many bring the relative standard error down to this."""
        return math.ceil((self.spread / standard_error) ** 2)


QUESTIONS = (
    Question(Case(20.0, 0.8, 0.002), limit=18.00, spread=0.70, euler_bias=0.41, end=90.0),
    Question(Case(20.0, 0.8, 0.004), limit=12.02, spread=0.75, euler_bias=0.42, end=64.0),
    Question(Case(20.0, 0.2, 0.002), limit=1.591, spread=0.90, euler_bias=0.41, end=11.2),
    Question(Case(320.0, 0.2, 0.002), limit=8.83, spread=1.49, euler_bias=0.44, end=102.0),
)


@dataclass(eq=False)
class Paper:
    """The paper's algorithm in C. Its bias is known, so that a part 1/sqrt(2) of the error for each is cheapest."""

    question: Question
    reference: Reference
    bias: float
    share: int = 1  # 1 in so many of the swimmers are swum
    times: np.ndarray = field(default_factory=lambda: np.zeros(0))  # (n,) T_theta, a/U
    steps: int = 0  # of all swimmers that swam

    @property
    def step(self) -> float:
        """At which the bias is what it may be."""
        return (self.bias / self.question.euler_bias) ** 2

    @property
    def n_swimmers(self) -> int:
        """Of an answer; all of them swim where the share is 1."""
        return self.question.swimmers(self.bias)

    def work(self) -> int:
        """Swim until all have passed."""
        case = self.question.case
        job = OneColloid(case.radius, case.alpha, case.D, self.step)
        passages = self.reference.passages(-(-self.n_swimmers // self.share), sine=self.question.sine, job=job)
        self.times = passages * self.step
        self.steps = int(passages.sum())
        return self.steps


@dataclass(eq=False)
class Engine:
    """A batch of one scene with `reflected`, from the scene to T_theta."""

    question: Question
    tolerance: float
    step: float = STEP
    bias: float = BIAS
    times: np.ndarray = field(default_factory=lambda: np.zeros(0))  # (n,) T_theta, a/U
    steps: int = 0  # of all swimmers that swam

    @property
    def n_swimmers(self) -> int:
        """Of an answer."""
        return self.question.swimmers(math.sqrt(self.tolerance**2 - self.bias**2))

    def work(self) -> int:
        """Swim to the end."""
        n_steps = round(self.question.end / self.step)
        duration = n_steps * self.step
        scene = paper_scene("trapping").replace({
            "swimmers.count": self.n_swimmers, "record.every": duration,
            "run": {
                "time_step": self.step, "duration": duration, "seed": 1, "integrator": "reflected",
                "precision": "f32", "device": "cpu", "threads": 1,
            },
        })  # fmt: skip
        (found,) = trapping_times(scene, [self.question.case])
        self.times = found.pitch
        self.steps = self.n_swimmers * n_steps
        return self.steps


def figures(setting: Setting) -> Sequence[Figure]:
    """For each question: times of C over those of the engine, and what each side has found with what error."""
    return [figure for question in QUESTIONS for figure in _asked(setting, question)]


def _asked(setting: Setting, question: Question) -> list[Figure]:
    tolerance, rounds = setting.counts.tolerance, max(2, setting.counts.rounds // 3)
    c, engine = setting.references, Engine(question, tolerance)
    if c.blocked is None or c.scalar is None:
        return []
    blocked = Paper(question, c.blocked, tolerance / math.sqrt(2.0))
    scalar = Paper(question, c.scalar, blocked.bias, SCALAR_SHARE)
    times = take_turns({"engine": engine.work, "blocked C": blocked.work, "scalar C": scalar.work}, rounds)
    # scalar C would take the steps of blocked C: its swimmers have the same paths
    steps = {"engine": engine.steps, "blocked C": blocked.steps, "scalar C": blocked.steps}
    where = _where(engine, rounds)
    faster = []
    for name, target in TARGETS.items():
        ratio = Ratio.of(times[name] * steps[name] / (times["engine"] * steps["engine"]))
        faster.append(
            Figure(
                f"time to T_theta at {question.text}, {name} over engine", ratio.median, where,
                target=target if question is QUESTIONS[0] else None, at_least=True, quartiles=(ratio.low, ratio.high),
                nanoseconds={one: float(times[one].min()) for one in ("engine", name)},
            )
        )  # fmt: skip
    return [*faster, *_found("engine", engine), *_found("blocked C", blocked)]


def _found(name: str, side: Engine | Paper) -> list[Figure]:
    """What a side answers, and how far that may be from the truth."""
    mean, standard_error = mean_of(side.times)
    what, where = f"{side.question.text}, {name}, step {side.step:.2g}", _where(side, 1)
    error = 100.0 * math.hypot(side.bias, standard_error / mean)
    return [
        Figure(f"total error of T_theta at {what}", error, where, unit="percent"),
        Figure(f"T_theta at {what}, over its limit", mean / side.question.limit, where),
    ]


def _where(side: Engine | Paper, rounds: int) -> Conditions:
    return Conditions("f32", 1, side.n_swimmers, 1, round(side.steps / side.n_swimmers), rounds=rounds)
