"""The scalar pass over the lanes of a block: what each of them waits for."""

# No `from __future__ import annotations`: Taichi needs live annotations in kernel modules.
from functools import cache

import taichi as ti

from porous_swim.engine.kernel.commit import make_commit
from porous_swim.engine.kernel.encounters import make_encounters, make_refresh_neighbours
from porous_swim.engine.kernel.locate import LOCATED_BAND
from porous_swim.engine.kernel.pairs import make_swap
from porous_swim.engine.kernel.resolve_contacts import make_resolve_contacts
from porous_swim.engine.kernel.rows import make_vectors, make_wide, rows_of
from porous_swim.engine.kernel.state import Event, Int, LaneInt
from porous_swim.physics.contact import HardContact
from porous_swim.physics.model import Model
from porous_swim.physics.surface import make_surface


@cache
def make_handle_events(model: Model):
    """Return `handle_all_events(reals, ints, swimmers, medium, log, rules)`, which does what the lanes wait for."""
    real, lanes, located, partners = model.real, model.lanes, model.located, model.partners
    rows, (whole, _), (get, put) = rows_of(model), make_wide(model), make_vectors(model)
    resolve_contacts, commit = make_resolve_contacts(model), make_commit(model)
    refresh_neighbours, encounters = make_refresh_neighbours(model), make_encounters(model)
    contact_height, to, (_, sync) = HardContact.make_rolled_height(model), make_surface(model), make_swap(model)
    WideInt = ti.types.vector(lanes, ti.i32)

    @ti.func
    def handle_events(reals: ti.template(), ints: ti.template(), j, i, swimmers: ti.template(), medium: ti.template(),
               log: ti.template(), rules: ti.template()):  # fmt: skip
        """Do what lane j (swimmer i) waits for. What needs the log may have to wait for the next launch."""
        if ti.static(partners):
            sync(ints, j, i, swimmers)
        event = ints[Int.EVENT][j]
        ints[Int.EVENT][j] = event & int(Event.CONTACT | Event.ESCAPE | Event.PITCH)
        if event & int(Event.LOCATE):  # a swimmer just placed stays where it is
            put(reals, rows.trial_x, j, get(reals, rows.x, j))
            put(reals, rows.trial_e, j, get(reals, rows.e, j))
        if event & int(Event.LOCATE | Event.FINISH):
            band = rules.tolerance
            if ti.static(located):  # a swimmer released that near touches; later a touch is a touch
                band = ti.select(event & int(Event.LOCATE), band, real(LOCATED_BAND))
            resolve_contacts(reals, ints, j, i, swimmers, medium, rules, band)
        refresh_neighbours(reals, ints, j, i, swimmers, medium)
        if ints[Int.EVENT][j] & int(Event.HALT) == 0:
            if event & int(Event.FINISH):
                ints[LaneInt.SETTLED][j] = 1
            else:
                if event & int(Event.LOCATE):
                    touch = (ints[LaneInt.TOUCH][j] != 0) & (ints[LaneInt.WATCH_CONTACT][j] != 0)
                    ints[Int.EVENT][j] |= ti.select(touch, int(Event.CONTACT), 0)
                if ints[Int.EVENT][j] != 0:
                    encounters(reals, ints, j, i, swimmers, medium, log, rules)

    @ti.func
    def handle_all_events(reals: ti.template(), ints: ti.template(), swimmers: ti.template(), medium: ti.template(),
                   log: ti.template(), rules: ti.template()):  # fmt: skip
        """Resolve contacts and commit; what comes of it; refresh the neighbours of those whose encounter it changed."""
        for _ in range(3):
            waiting, settled = 0, 0
            for j in range(lanes):
                waiting |= ints[Int.EVENT][j]
            if (waiting & ~int(Event.HALT)) != 0:
                for j in range(lanes):
                    if (ints[Int.EVENT][j] != 0) & ((ints[Int.EVENT][j] & int(Event.HALT)) == 0):
                        handle_events(reals, ints, j, ints[LaneInt.SWIMMER][j], swimmers, medium, log, rules)
                        settled |= ints[LaneInt.SETTLED][j]
            if settled != 0:
                r = whole(reals, rows.trial_x) + whole(reals, rows.bound_offset)
                s = to.sine(r, whole(reals, rows.trial_e), to.distance(r))
                least = contact_height(s, reals[rows.law.gamma], reals[rows.bound_A])
                commit(reals, ints, ints[LaneInt.SETTLED] != 0, rules, least)
                ints[LaneInt.SETTLED] = WideInt(0)

    return handle_all_events
