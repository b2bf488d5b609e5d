"""Which colloid is nearest: the search on the device, over the candidates of one cell. Exact for any radii."""

# No `from __future__ import annotations`: Taichi needs live annotations in kernel modules.
from functools import cache
from types import SimpleNamespace
from typing import Any, NamedTuple

import taichi as ti

from porous_swim.obstacles.cells import FIXED_BITS
from porous_swim.physics.contact import HardContact
from porous_swim.physics.model import Model
from porous_swim.physics.surface import make_surface
from porous_swim.physics.vectors import record, vec


class Medium(NamedTuple):
    """The colloids as kernel arguments; see `cells.CellIndex`."""

    center: Any  # (n_colloids, 3) i64, fixed point
    radius: Any  # (n_colloids,) real, distance at the surface: `ObstacleField.at_surface`
    first: Any  # (n_cells + 1,) i32
    candidate: Any  # (n_candidates, 2) i32: colloid, packed image
    least: Any  # (n_candidates,) real, a; no point of the cell is nearer to the surface of the candidate
    grid: Any  # (7,) i32: cells along each axis, whether it repeats, number of colloids
    scale: Any  # (2, 3) real: length of a unit of the fixed point, and its inverse


TOUCHED = 1.5  # a, beyond all contact heights


@cache
def make_between(model: Model):
    """Return `between(medium, k, image_k, j, image_j)`: centre of j minus centre of k, exact before its rounding."""
    real, dimensions = model.real, model.dimensions

    @ti.func
    def between(medium: ti.template(), k, image_k, j, image_j):
        v = vec(*[real(0.0) for _ in ti.static(range(dimensions))])
        for d in ti.static(range(dimensions)):
            n = medium.center[j, d] - medium.center[k, d]
            n += ti.cast(image_j[d] - image_k[d], ti.i64) << ti.i64(FIXED_BITS)
            v[d] = ti.cast(n, real) * medium.scale[0, d]
        return v

    return between


@cache
def make_fixed(model: Model):
    """Return `fixed_position(medium, k, y)`, the place at offset y from colloid k, and whether a cell covers it.

    In units of the fixed point, seen from the box of that image of the colloid.
    """
    real, dimensions = model.real, model.dimensions

    @ti.func
    def fixed_position(medium: ti.template(), k, y):
        p = vec(ti.i64(0), ti.i64(0), ti.i64(0))
        covered = 1
        for d in ti.static(range(dimensions)):
            n = y[d] * medium.scale[1, d]
            far = ti.abs(n) > real(2.0**60)
            p[d] = medium.center[k, d] + ti.cast(ti.select(far, real(0.0), n), ti.i64)
            beyond = (medium.grid[3 + d] == 0) & ((p[d] >> ti.i64(FIXED_BITS)) != 0)
            covered = ti.select(far | beyond, 0, covered)
        return p, covered

    return fixed_position


@cache
def make_note(model: Model):
    """Return `note(found, j, origin, shift, distance, height)`, which takes colloid j into the result of a search.

    Its image is origin + shift, its surface at `distance`; `height` is the contact height there of what is no sphere.
    """

    @ti.func
    def note(found, j, origin, shift, distance, height):
        if ti.static(not model.sphere):
            if distance < found.first:
                found.third = ti.min(found.third, found.second)
                found.partner, found.partner_image = found.near, found.image
            elif distance < found.second:
                found.third = ti.min(found.third, found.second)
                found.partner, found.partner_image = j, origin + shift
            else:
                found.third = ti.min(found.third, distance)
        if distance < found.first:
            found.second, found.first = found.first, distance
            found.near, found.image = j, origin + shift
        elif distance < found.second:
            found.second = distance
        if ti.static(not model.sphere):
            depth = height - distance
            if depth > found.depth:
                found.deep, found.deep_image, found.depth = j, origin + shift, depth

    return note


@cache
def make_search(model: Model):
    """Return a namespace of `run(medium, k, image, y, e, gamma)` and `empty()`, the result of no search.

    The swimmer is at offset y from image `image` of colloid k.

    The result holds the nearest colloid, its image, the distances to the nearest and second nearest surface, and the
    colloid into which the swimmer reaches deepest, with the depth (negative: free). Of a rod also its `partner`, the
    second nearest, and the distance to the third nearest, up to TOUCHED. Distances in a.
    """
    real, dimensions, sphere = model.real, model.dimensions, model.sphere
    contact_height, to = HardContact.make_rolled_height(model), make_surface(model)
    fixed_position, note = make_fixed(model), make_note(model)

    @ti.func
    def empty():
        none = vec(0, 0, 0)
        return record(
            near=-1, image=none, first=real(1e30), second=real(1e30), deep=-1, deep_image=none, depth=real(-1e30),
            partner=-1, partner_image=none, third=real(TOUCHED),
        )  # fmt: skip

    @ti.func
    def run(medium: ti.template(), k, image, y, e, gamma):
        p, covered = fixed_position(medium, k, y)
        box = vec(0, 0, 0)
        cell = 0
        if covered != 0:
            for d in ti.static(range(dimensions)):
                box[d] = ti.cast(p[d] >> ti.i64(FIXED_BITS), ti.i32)
                p[d] -= ti.cast(box[d], ti.i64) << ti.i64(FIXED_BITS)
            for d in ti.static(range(3)):
                slot = ti.cast((p[d] * ti.cast(medium.grid[d], ti.i64)) >> ti.i64(FIXED_BITS), ti.i32)
                cell = cell * medium.grid[d] + slot
        # outside of what the cells cover every colloid is a candidate
        begin = ti.select(covered != 0, medium.first[cell], 0)
        end = ti.select(covered != 0, medium.first[cell + 1], medium.grid[6])
        found, origin = empty(), image + box
        m = begin
        while m < end:
            j, packed = m, 0x808080
            if covered != 0:
                j, packed = medium.candidate[m, 0], medium.candidate[m, 1]
            v = vec(*[real(0.0) for _ in ti.static(range(dimensions))])
            shift = vec(0, 0, 0)
            for d in ti.static(range(dimensions)):
                shift[d] = ((packed >> (8 * d)) & 0xFF) - 128
                if covered != 0:
                    n = p[d] - medium.center[j, d] - (ti.cast(shift[d], ti.i64) << ti.i64(FIXED_BITS))
                    v[d] = ti.cast(n, real) * medium.scale[0, d]
                else:
                    v[d] = y[d] + ti.cast(medium.center[k, d] - medium.center[j, d], real) * medium.scale[0, d]
            R = to.distance(v)
            distance = R - medium.radius[j]
            height = real(1.0)
            if ti.static(not sphere):
                height = contact_height(to.sine(v, e, R), gamma, medium.radius[j])
            note(found, j, origin, shift, distance, height)
            m += 1
            # nobody further down the list of a cell is second nearest, nor touched: contact heights are at most 1
            rest = medium.least[ti.min(m, end - 1)] > ti.max(found.second, real(TOUCHED))
            m = ti.select((covered != 0) & rest, end, m)
        if ti.static(sphere):  # whose contact height is the same everywhere: the deepest is the nearest
            found.deep, found.deep_image, found.depth = found.near, found.image, real(1.0) - found.first
        return found

    return SimpleNamespace(run=run, empty=empty)
