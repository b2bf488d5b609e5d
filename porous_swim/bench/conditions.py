"""The engine against itself: lanes, precision, noise, number of swimmers, memory. In the fcc lattice, everything on."""

from __future__ import annotations

from collections.abc import Sequence

from porous_swim.bench.figure import Conditions, Figure, Setting, compared
from porous_swim.bench.job import crystal, lattice, single
from porous_swim.bench.timing import take_turns
from porous_swim.bench.works import Placed
from porous_swim.scene.scene import Scene

MOST_BYTES = 200


def precision(setting: Setting) -> Sequence[Figure]:
    """Double over single precision."""
    n = setting.counts.n_swimmers
    return [_pair(setting, "double over single precision", lattice(n, run__precision="f64"), target=2.2)]


def noise(setting: Setting) -> Sequence[Figure]:
    """Gaussian over uniform increments."""
    n = setting.counts.n_swimmers
    return [_pair(setting, "Gaussian over uniform noise", lattice(n, noise__variates="gaussian"), target=2.0)]


def _pair(setting: Setting, name: str, scene: Scene, *, target: float) -> Figure:
    """A changed lattice over the lattice; `name` is that of the one, `over`, and that of the other."""
    left, _, right = name.partition(" over ")
    counts, n = setting.counts, setting.counts.n_swimmers
    changed, plain = Placed.of(scene), Placed.of(lattice(n))
    times = take_turns({left: changed.work(counts.n_steps), right: plain.work(counts.n_steps)}, counts.rounds)
    where = Conditions(changed.simulation.scene.precision, 1, n, plain.n_colloids, counts.n_steps, rounds=counts.rounds)
    return compared(name, times, left, right, where, target=target)


def lanes(setting: Setting) -> Sequence[Figure]:
    """The engine over the same kernel with one lane to a block, for one colloid and for a field."""
    counts, n = setting.counts, setting.counts.n_swimmers
    figures = []
    for name, scene in (("one colloid", single(n)), ("fcc lattice", lattice(n))):
        narrow, wide = Placed.of(scene, lanes=1), Placed.of(scene)
        times = take_turns({"one lane": narrow.work(counts.n_steps), "lanes": wide.work(counts.n_steps)}, counts.rounds)
        where = Conditions("f32", 1, n, wide.n_colloids, counts.n_steps, rounds=counts.rounds)
        figures.append(compared(f"{name}, lanes over one lane", times, "lanes", "one lane", where, target=0.5))
    return figures


def populations(setting: Setting) -> Sequence[Figure]:
    """Numbers of swimmers, each over the second; launches of equal length, as many as make equal work."""
    counts = setting.counts
    n_steps = max(1, counts.n_steps // 10)
    rounds = max(2, counts.rounds // 2)
    placed = {f"{n} swimmers": Placed.of(lattice(n), settling=n_steps) for n in counts.populations}
    names = list(placed)
    base, most = names[1], names[-1]
    works = {}
    for name, n in zip(names, counts.populations, strict=True):
        works[name] = placed[name].work(n_steps, launches=max(1, counts.populations[-1] // n // 10))
    times = take_turns(works, rounds)
    return [
        compared(
            f"{name} over {base}", times, name, base,
            Conditions("f32", 1, n, placed[name].n_colloids, n_steps, rounds=rounds),
            target=1.1 if name == most else None,
        )
        for name, n in zip(names, counts.populations, strict=True) if name != base
    ]  # fmt: skip


def memory(setting: Setting) -> Sequence[Figure]:
    """Bytes on the device for each swimmer, exactly."""
    n = setting.counts.n_swimmers
    scenes = [crystal(n), lattice(n), lattice(n, run__precision="f64")]
    placed = [Placed.of(scene, settling=0).simulation for scene in scenes]
    return [
        Figure(
            f"memory of a swimmer, {one.field.dimensions}-D, {one.scene.precision}",
            one.engine.bytes_per_swimmer,
            Conditions(one.scene.precision, 1, n, len(one.field.radii), 0, one.field.dimensions),
            target=MOST_BYTES if one.scene.precision == "f32" else None,
            unit="bytes",
        )
        for one in placed
    ]
