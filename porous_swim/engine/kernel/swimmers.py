"""The state of all swimmers and the numbers of the run, as kernel arguments."""

# No `from __future__ import annotations`: Taichi needs live annotations in kernel modules.
from typing import Any, NamedTuple

import taichi as ti

from porous_swim.engine.kernel.state import Int
from porous_swim.physics.vectors import vec

IMAGE_BITS = 10
# periodic boxes from a colloid to another that is touched during its encounter: as far as the escape height reaches at
# most, which `cells.MOST_IMAGES` bounds
HALF_RANGE = 1 << (IMAGE_BITS - 1)


class Swimmers(NamedTuple):
    """The state of all swimmers; rows in `state`."""

    real: Any  # (n_memory, n_swimmers)
    int: Any  # (n_ints, n_swimmers) i32
    long: Any  # (len(Long), n_swimmers) i64
    law: Any  # (n_sets, len(model.numbers)) real, the table of parameter sets
    total: Any  # (len(Total),) i64


class Rules(NamedTuple):
    """Numbers of the run."""

    dt: Any
    escape_height: Any
    contact_band: Any
    tolerance: Any  # depth of a contact that is taken as rounding
    margin: Any  # rounding of the distances that make a budget
    first: Any  # i64, the step before this launch
    first_low: Any  # u32
    first_high: Any
    key0: Any
    key1: Any
    flight_ticks: Any  # i32, steps that a move far from every colloid takes at once
    flight_height: Any  # from where on it is far
    tableau: Any  # of `physics.located`; one number where events are not located


@ti.func
def image_of(swimmers: ti.template(), row: ti.template(), i):
    """The periodic image in three rows of swimmer i."""
    return vec(swimmers.int[row, i], swimmers.int[row + 1, i], swimmers.int[row + 2, i])


@ti.func
def put_image(swimmers: ti.template(), row: ti.template(), i, image):
    """Store a periodic image in three rows of swimmer i."""
    for d in ti.static(range(3)):
        swimmers.int[row + d, i] = image[d]


@ti.func
def packed(image, other):
    """How an image differs from another one near it, in one word."""
    word = 0
    for d in ti.static(range(3)):
        word |= (image[d] - other[d] + HALF_RANGE) << (d * IMAGE_BITS)
    return word


@ti.func
def unpacked(word, other):
    """The image again."""
    return vec(
        *[((word >> (d * IMAGE_BITS)) & (2 * HALF_RANGE - 1)) - HALF_RANGE + other[d] for d in ti.static(range(3))]
    )


@ti.func
def touched_image(swimmers: ti.template(), i):
    """The image of the other colloid that swimmer i touched during its encounter."""
    return unpacked(swimmers.int[int(Int.TOUCHED_IMAGE), i], image_of(swimmers, int(Int.BOUND_IMAGE), i))


@ti.func
def set_of(swimmers: ti.template(), i):
    """The row of swimmer i in the table of parameter sets."""
    row = 0
    if swimmers.law.shape[0] > 1:
        row = swimmers.int[int(Int.SET), i]
    return row


@ti.func
def same(k, image, j, image_j):
    """Whether two colloids, images included, are one. (`&`: a short-circuiting `and` would compile to branches.)"""
    return (k == j) & (image[0] == image_j[0]) & (image[1] == image_j[1]) & (image[2] == image_j[2])
