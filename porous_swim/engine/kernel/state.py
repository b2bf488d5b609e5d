"""What the device keeps of each swimmer, and how the lanes of a block hold it."""

from __future__ import annotations

from enum import IntEnum, IntFlag
from functools import cache
from types import SimpleNamespace

from porous_swim.results.encounter_columns import records


class Phase(IntEnum):
    """Where a swimmer stands in its life of encounters."""

    FREE = 0
    BOUND = 1
    LEFT = 2  # its encounter has ended, its first passage of the escape pitch is still awaited


class Event(IntFlag):
    """What a lane waits for the scalar pass to do. A lane moves only while it waits for nothing."""

    LOCATE = 1  # find the nearest colloid of a newly placed swimmer
    FINISH = 2  # the budget is spent: resolve contact with every colloid, search, commit the step
    CONTACT = 4  # touches a colloid that is news to it
    ESCAPE = 8  # above the escape height
    PITCH = 16  # first passage of the escape pitch
    REFRESH = 32  # its relations to the colloids around it are out of date
    HALT = 64  # status is not OK: never moves again


class Int(IntEnum):
    """Rows of 32-bit integers. The first two live in memory and in the lanes."""

    STEP = 0  # steps since the first of this launch
    EVENT = 1  # in memory with the phase, from PHASE_BIT on
    # in memory only
    COLLOID = 2  # the nearest, from which the offset is measured
    IMAGE = 3  # its periodic image, three rows
    BOUND = 6  # the colloid of the present or latest encounter; -1 before the first
    BOUND_IMAGE = 7
    TOUCHED = 10  # another colloid touched during the encounter, the last such; -1 if none
    TOUCHED_IMAGE = 11  # less that of the encounter, in one row: see `swimmers.packed`
    SET = 12  # row of the table of parameter sets; where there is more than one
    # where events are located, and of rods among spheres
    PARTNER = 13  # of a swimmer between two colloids, the other one; -1 elsewhere
    PARTNER_IMAGE = 14
    # where events are located only
    TOUCHED_BODY = 17
    TOUCHED_BODY_IMAGE = 18


class LaneInt(IntEnum):
    """Rows of 32-bit integers that only the lanes have, behind their copies of the first rows of `Int`."""

    PHASE = 2
    OWN = 3  # the nearest colloid is that of the encounter
    WATCH_CONTACT = 4  # contact with the nearest colloid is news
    WATCH_PITCH = 5  # the escape pitch has not been passed yet
    TOUCH = 6  # the trial move ends at the wall of the nearest colloid
    N_CONTACT = 7  # steps in contact, of this launch
    RELEASE = 8  # step after which the wall was last touched, of this launch; -1 if none
    LOW = 9  # a located move began in the contact band
    BETWEEN = 10  # there is a partner
    SETTLED = 11  # the trial move has been settled and is to be booked
    SWIMMER = 12  # number of the swimmer in the lane; -1 if none
    TICKS = 13  # steps that the trial move takes at once: several in a flight far from every colloid
    AFTER = 14  # steps since the last one at which a flight may begin
    TOUCHED_BODY = 15  # the colloid that a contact is with: the nearest, but where several are touched
    TOUCHED_BODY_IMAGE = 16  # three rows
    PAIRED = 19  # a rod's steps obey contact with a second colloid, too: its partner
    PARTNER_OWN = 20  # which is that of the encounter
    PARTNER_KNOWN = 21  # contact with it is no news
    SWAPPED = 22  # it has become the nearest colloid, and that its partner; memory does not know yet


class Long(IntEnum):
    """Rows of 64-bit integers, in memory only: whole steps since the start of the run, -1 for never."""

    START = 0
    RELEASE = 1
    PITCH = 2
    N_CONTACT = 3


class Total(IntEnum):
    """Counters over all swimmers."""

    CAPTURES = 0
    ESCAPES = 1
    HOPS = 2
    RETURNS = 3
    LOGGED = 4  # rows asked of the log since it was drained
    FINISHED = 5  # swimmers that reached the last step of this launch
    HALTED = 6
    JAMMED = 7  # steps of swimmers at which no place was found that obeys contact with every colloid


N_LANE_INTS = 23  # rows of the lanes, an image taking three
PHASE_BIT = 8
MIDDLE = -0.5  # clock of the middle of the step that is behind: when a path crosses a threshold, for all that is known


def n_ints(*, located: bool, partners: bool, n_sets: int) -> int:
    """Rows of `Int` in memory, images taking three."""
    return 21 if located else 17 if partners else 13 if n_sets > 1 else 12


def clock_of_events(integrator: str) -> float | None:
    """The clock of everything that happens in a step, but at the start of the run; None where each has its own."""
    return {"euler": 0.0, "reflected": MIDDLE, "located": None}[integrator]


@cache
def real_rows(dimensions: int, *, located: bool, numbers: tuple[str, ...] = ()) -> SimpleNamespace:
    """Row numbers of the real arrays; `x` names the first of `dimensions` rows.

    The first `n_shared` rows live in the lanes and in memory, the next ones in memory only (up to `n_memory`) or
    in the lanes only (up to `n_lanes`). A row `*_rest` behind a sum is what its rounding left (Kahan summation).
    `clock` is the part of the present step that is behind a swimmer, and `*_clock` what a number of whole steps
    lacks: rows of their own where events are located; else see `clock_of_events`. The record of the encounter under way
    has the rows of `encounter_columns`. `law` has the rows of the swimmer's `numbers`, in the lanes only.
    """
    rows = SimpleNamespace()

    def number(start: int, vectors: str, scalars: str) -> int:
        for names, size in ((vectors, dimensions), (scalars, 1)):
            for name in names.split():
                if hasattr(rows, name):
                    raise ValueError(f"two rows of the state have the name {name!r}")
                setattr(rows, name, start)
                start += size
        return start

    record = " ".join(row for kept in records(dimensions) for row in kept.rows)
    clocks = " clock start_clock pitch_clock release_clock" if located else ""
    rows.n_shared = number(
        0,
        "x rest e reference",
        f"budget {record} contact_clock{clocks}",
    )
    rows.n_memory = number(rows.n_shared, "entry_x entry_e", "")
    first_number = number(
        rows.n_shared,
        "bound_offset partner_offset trial_x trial_rest trial_e",
        "A bound_A partner_A trial_push trial_clock trial_height "
        "height_excursion pitch_excursion" + ("" if located else " clock"),
    )
    rows.law = SimpleNamespace(**{name: first_number + k for k, name in enumerate(numbers)})
    rows.n_lanes = first_number + len(numbers)
    return rows
