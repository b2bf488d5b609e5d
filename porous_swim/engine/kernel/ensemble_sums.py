"""What all swimmers do together, summed where they are: nothing but sums over groups of swimmers leaves the device.

Swimmers do not feel each other, so groups of them are independent samples, from which errors follow. Sums are those of
differences from the first swimmer of a group, so that single precision does for them.
"""

# No `from __future__ import annotations`: Taichi needs live annotations in kernel modules.
from collections.abc import Iterable
from dataclasses import dataclass
from enum import IntEnum
from functools import cache

import numpy as np
import taichi as ti

from porous_swim.core.state import State, fitting
from porous_swim.engine.backend import check_alive
from porous_swim.engine.kernel.rows import rows_of
from porous_swim.engine.kernel.state import PHASE_BIT, Int, Phase
from porous_swim.engine.kernel.swimmers import Swimmers, image_of, set_of
from porous_swim.engine.medium import on_device
from porous_swim.engine.transfer import on_host, to_device
from porous_swim.obstacles.search import Medium, make_between
from porous_swim.physics.contact import HardContact
from porous_swim.physics.model import Model
from porous_swim.physics.surface import make_surface
from porous_swim.physics.vectors import vec

FEWEST_GROUPS = 256  # where there are as many swimmers; groups are no larger than LARGEST
LARGEST = 256


class Sum(IntEnum):
    """Columns of the sums over a group."""

    BOUND = 0
    CONTACT = 1
    FIRST = 2  # squared displacement of the first swimmer
    SQUARE = 3  # of the others, what it is more
    SQUARED = 4  # the same, squared
    OVERLAP = 5  # scalar product of the director with that at the origin


@dataclass(frozen=True, eq=False)
class Groups:
    """Sums over groups of swimmers, at one moment, with displacements from an origin in time."""

    n: np.ndarray  # (n_groups,) swimmers
    bound: np.ndarray  # (n_groups,) how many are in an encounter; 0 beyond level 0
    contact: np.ndarray  # (n_groups,) how many are in contact; likewise
    square: np.ndarray  # (n_groups,) a^2, mean squared displacement
    spread: np.ndarray  # (n_groups,) a^4, sum of squared deviations of the squared displacement from that mean
    overlap: np.ndarray  # (n_groups,) mean scalar product of directors

    @classmethod
    def of(cls, n: np.ndarray, sums: np.ndarray) -> "Groups":
        """From rows of sums, (n_groups, len(Sum))."""
        more = sums[:, Sum.SQUARE] / n
        spread = np.maximum(sums[:, Sum.SQUARED] - n * more**2, 0.0)
        bound, contact = sums[:, Sum.BOUND], sums[:, Sum.CONTACT]
        return cls(n, bound, contact, sums[:, Sum.FIRST] + more, spread, sums[:, Sum.OVERLAP] / n)


@cache
def make_vector(model: Model):
    """Return `vector(table, row, i)`, a vector of swimmer i in memory."""
    dimensions = model.dimensions

    @ti.func
    def vector(table: ti.template(), row: ti.template(), i):
        return vec(*[table[row + d, i] for d in ti.static(range(dimensions))])

    return vector


@cache
def make_stance(model: Model):
    """Return `stance(swimmers, medium, i, band)`: whether swimmer i is bound, and whether in contact; as numbers."""
    real, rows, column = model.real, rows_of(model), model.numbers.index("gamma")
    contact_height, between, to = HardContact.make_height(model), make_between(model), make_surface(model)
    vector = make_vector(model)

    @ti.func
    def stance(swimmers: ti.template(), medium: ti.template(), i, band):
        b, image_b = swimmers.int[int(Int.BOUND), i], image_of(swimmers, int(Int.BOUND_IMAGE), i)
        k, image = swimmers.int[int(Int.COLLOID), i], image_of(swimmers, int(Int.IMAGE), i)
        bound, low = swimmers.int[int(Int.EVENT), i] >> PHASE_BIT == int(Phase.BOUND), False
        if bound:
            r = vector(swimmers.real, rows.x, i) + between(medium, b, image_b, k, image)
            R = to.distance(r)
            gamma = swimmers.law[set_of(swimmers, i), column]
            least = contact_height(to.sine(r, vector(swimmers.real, rows.e, i), R), gamma, medium.radius[b])
            low = R - medium.radius[b] - least <= band
        return ti.cast(bound, real), ti.cast(low, real)

    return stance


@cache
def make_ensemble_sums(model: Model):
    """Compile `survey(...)`, which sums over groups, level by level; `renew` makes the present the origin of a level.

    Levels are bits of `due` and `renew`; sums have a row for each level and group.
    """
    real, dimensions, rows = model.real, model.dimensions, rows_of(model)
    between, vector, stance = make_between(model), make_vector(model), make_stance(model)
    reals, ints, longs = (ti.types.ndarray(t, ndim=2) for t in (real, ti.i32, ti.i64))
    real_row = ti.types.ndarray(real, ndim=1)

    @ti.func
    def begin(
        state: ti.template(), state_int: ti.template(), origin: ti.template(), origin_int: ti.template(), level, i
    ):  # fmt: skip
        """Make the present the origin of a level for swimmer i."""
        origin_int[4 * level, i] = state_int[int(Int.COLLOID), i]
        for d in ti.static(range(3)):
            origin_int[4 * level + 1 + d, i] = state_int[int(Int.IMAGE) + d, i]
        for d in ti.static(range(dimensions)):
            for vector_number, row in ti.static(enumerate((rows.x, rows.rest, rows.e))):
                origin[dimensions * (3 * level + vector_number) + d, i] = state[row + d, i]

    @ti.kernel
    def survey(
        state: reals, state_int: ints, law: reals, center: longs, radius: real_row, scale: reals,
        origin: reals, origin_int: ints, sums: reals, due: ti.i32, renew: ti.i32, n_groups: ti.i32, size: ti.i32,
        band: real,
    ):  # fmt: skip
        swimmers = ti.static(Swimmers(state, state_int, None, law, None))
        medium = ti.static(Medium(center, radius, None, None, None, None, scale))
        for row in range(sums.shape[0]):
            level, g = row // n_groups, row % n_groups
            if (due >> level) & 1:
                total = [real(0.0) for _ in ti.static(range(len(Sum)))]
                for i in range(g * size, ti.min((g + 1) * size, state.shape[1])):
                    bound, low = real(0.0), real(0.0)
                    if level == 0:  # enough to know it once a look
                        bound, low = stance(swimmers, medium, i, band)
                    k, image = state_int[int(Int.COLLOID), i], image_of(swimmers, int(Int.IMAGE), i)
                    k0 = origin_int[4 * level, i]
                    image0 = vec(*[origin_int[4 * level + 1 + d, i] for d in ti.static(range(3))])
                    moved, e = between(medium, k0, image0, k, image), vector(state, rows.e, i)
                    overlap = real(0.0)
                    first = 3 * dimensions * level
                    for d in ti.static(range(dimensions)):
                        x, rest = state[rows.x + d, i] - origin[first + d, i], state[rows.rest + d, i]
                        moved[d] = moved[d] + x + (rest - origin[first + dimensions + d, i])
                        overlap += e[d] * origin[first + 2 * dimensions + d, i]
                    square = moved.dot(moved)
                    if i == g * size:
                        total[int(Sum.FIRST)] = square
                    more = square - total[int(Sum.FIRST)]
                    total[int(Sum.BOUND)] += bound
                    total[int(Sum.CONTACT)] += low
                    total[int(Sum.SQUARE)] += more
                    total[int(Sum.SQUARED)] += more * more
                    total[int(Sum.OVERLAP)] += overlap
                    if (renew >> level) & 1:
                        begin(state, state_int, origin, origin_int, level, i)
                for column in ti.static(range(len(Sum))):
                    sums[row, column] = total[column]

    return survey


class EnsembleSums:
    """The sums of a run: origins in time for each of `n_levels`, that of level 0 being the start.

    `n_levels` x (4 + 3 dimensions) numbers for each swimmer are kept on the device.
    """

    def __init__(
        self, swimmers: Swimmers, medium: Medium, kernel, *, dimensions: int, real: np.dtype, band: float, n_levels: int
    ) -> None:
        n = swimmers.real.shape[1]
        self._swimmers, self._medium, self._kernel, self._band = swimmers, medium, kernel, band
        self._size = max(1, min(LARGEST, n // FEWEST_GROUPS))
        n_groups = -(-n // self._size)
        self.group_sizes = np.diff(np.append(np.arange(n_groups) * self._size, n))  # (n_groups,) swimmers
        n_rows = n_groups * n_levels
        shapes = (3 * dimensions * n_levels, n, real), (4 * n_levels, n, np.int32), (n_rows, len(Sum), real)
        self._origin, self._origin_int, self._sums = (on_device(np.zeros(shape, t)) for *shape, t in shapes)
        self.look(range(n_levels), renew=range(n_levels))

    def look(self, levels: Iterable[int], *, renew: Iterable[int] = ()) -> list[Groups]:
        """All swimmers now, with displacements from the origin of each of `levels`; then `renew` those among them.

        All in one launch, as a launch takes longer than its sums.
        """
        check_alive()
        levels, swimmers, medium, n_groups = list(levels), self._swimmers, self._medium, len(self.group_sizes)
        self._kernel(
            swimmers.real, swimmers.int, swimmers.law, medium.center, medium.radius, medium.scale,
            self._origin, self._origin_int, self._sums, _bits(levels), _bits(renew), n_groups, self._size, self._band,
        )  # fmt: skip
        rows = np.add.outer(np.array(levels) * n_groups, np.arange(n_groups))
        return [Groups.of(self.group_sizes, sums) for sums in on_host(self._sums, rows).astype(float)]

    def state(self) -> dict[str, np.ndarray]:
        """The origins of all levels."""
        return {"origin": on_host(self._origin), "origin_int": on_host(self._origin_int)}

    def restore(self, state: State) -> None:
        """Go on from the `state` of another such run."""
        for name, table in (("origin", self._origin), ("origin_int", self._origin_int)):
            to_device(fitting(state, name, on_host(table)), table)


def _bits(levels: Iterable[int]) -> int:
    return sum(1 << level for level in set(levels))
