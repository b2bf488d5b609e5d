"""What a release is: it says where swimmers start."""

from __future__ import annotations

from abc import abstractmethod
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from porous_swim.core.parts import ContactHeight
from porous_swim.core.registry import OpenPart
from porous_swim.obstacles.domain import Domain
from porous_swim.obstacles.field import ObstacleField
from porous_swim.swimmers.placement import Swimmers


class Release(OpenPart):
    """Where swimmers start: a frozen model, chosen by `kind` in `swimmers.release`.

    A field `path` names a file, as that of a `Layout` does.
    """

    if TYPE_CHECKING:
        kind: str

    def check(self, domain: Domain) -> None:
        """Raise a `KeyedError` where release and `domain` do not fit, without placing anything; here: accept all.

        Errors name keys of the scene, such as `swimmers.release.position`.
        """

    @abstractmethod
    def place(
        self,
        field: ObstacleField,
        count: int,
        rng: np.random.Generator,
        contact_height: ContactHeight,
        *,
        folder: Path = Path(),
    ) -> Swimmers:
        """Return `count` swimmers at t = 0: positions (count, 3) in a, unit directors (count, 3), with z = 0 in 2-D.

        All keep their contact height above every colloid; `contact_height(sines of the pitch, radii)` gives it, and
        `porous_swim.swimmers.placement.checked_swimmers` asks for it. They follow from `rng` alone. A `KeyedError` says
        why they do not fit.
        """
