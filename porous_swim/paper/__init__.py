"""The figures of Spagnolie, Moreno-Flores, Bartolo and Lauga, Soft Matter 11, 3396 (2015), made again by the engine.

One module per figure: it runs scenes of `scenes/paper`, compares with the paper and with an independent simulator,
and draws. `FIGURES` is the one list of them.
"""

from __future__ import annotations

from collections.abc import Callable

from porous_swim.paper import (
    basin,
    bullseye,
    critical_radius,
    flow_fields,
    mean_trapping,
    pullers,
    random_swimming,
    scattering,
    trajectories,
    trapping,
    winding_number,
)
from porous_swim.paper.figure import Reproduction

_MODULES = (flow_fields, bullseye, critical_radius, pullers, basin, scattering, winding_number, random_swimming)
FIGURES: dict[str, tuple[str, Callable[[bool], Reproduction]]] = {
    **{module.NAME: (module.TITLE, module.reproduce) for module in _MODULES},
    "TrajectoriesA": (trajectories.TITLES["TrajectoriesA"], trajectories.reproduce_a),
    "TrajectoriesB": (trajectories.TITLES["TrajectoriesB"], trajectories.reproduce_b),
    trapping.NAME: (trapping.TITLE, trapping.reproduce),
    mean_trapping.NAME: (mean_trapping.TITLE, mean_trapping.reproduce),
}
