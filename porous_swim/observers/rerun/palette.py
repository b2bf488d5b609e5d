"""Colours and names of everything that a recording shows.

The colour-blind safe set of Okabe and Ito (2008): told apart on a dark ground and in the plots' white one.
"""

from __future__ import annotations

from porous_swim.observers.base import BOUND, CONTACT, FREE

STATE_NAMES = {FREE: "free", BOUND: "bound", CONTACT: "in contact"}
STATE_COLORS = {FREE: (86, 180, 233), BOUND: (240, 228, 66), CONTACT: (213, 94, 0)}

HOP_COLOR = (0, 158, 115)
RETURN_COLOR = (204, 121, 167)
MSD_COLOR = (230, 159, 0)
BAR_COLOR = (160, 170, 196)  # of distributions: no state's, nor a line's
HEIGHT_COLOR, PITCH_COLOR = (0, 114, 178), (230, 159, 0)
HOP_SHADES = (52, 74, 84), HOP_COLOR, (240, 228, 66)  # of the network, from rare to busy: lightness rises
DIRECTOR = (236, 236, 240)  # not the state's: an arrow must be seen on its own swimmer

GROUND = (16, 18, 22)
COLLOID = (150, 158, 178)
DOMAIN = (112, 118, 130)
