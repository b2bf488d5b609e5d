"""What every part of a scene is made of: frozen, strict models and the quantities they hold.

Lengths in swimmer half-lengths a, speeds in swimming speeds U, times in a/U.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, LiteralString

import numpy as np
from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, ValidationInfo
from pydantic_core import PydanticCustomError

from porous_swim.core.errors import SceneError
from porous_swim.core.numbers import Given

# What a number may be, generously: a swimmer is between some nanometres and a millimetre long, and neither its box nor
# its way is longer than a metre. Within these bounds no square or fourth power of a length leaves the floating range.
LONGEST = 1e9  # a
LEAST_RADIUS, LARGEST_RADIUS = 1e-3, 1e6  # a; of a colloid: from a molecule to a wall
FARTHEST = 1e6  # a; heights above a colloid, gaps between two
LEAST_TIME, LONGEST_TIME = 1e-9, 1e9  # a/U; less than the time between two collisions of molecules, and decades


UNITS_UNKNOWN: LiteralString = "units_unknown"  # in place of units that are wrong; the type of pydantic's error for it


class Part(BaseModel):
    """A frozen piece of a scene. Unknown keys, NaN and infinity are errors."""

    model_config = ConfigDict(
        frozen=True, extra="forbid", strict=True, allow_inf_nan=False, use_attribute_docstrings=True
    )
    NUMBERS: ClassVar[tuple[str, ...]] = ()
    """Names of the numbers that the part hands to the kernels, where they are `law.name`."""

    def numbers(self, given: Given) -> dict[str, float]:
        """Return a value for each of `NUMBERS`, in a, U and a/U."""
        return {}


class KeyedError(SceneError):
    """A scene that does not hold together: the dotted `key` to blame and the `sentence` about it."""

    def __init__(self, key: str, sentence: str):
        """Keep both parts; a scene puts the place in its file before them."""
        super().__init__(f"{key}: {sentence}")
        self.key, self.sentence = key, sentence

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle by both arguments, so that the error survives the way back from a worker process."""
        return type(self), (self.key, self.sentence)


class SeveralKeyedError(SceneError):
    """Several of them at once."""

    def __init__(self, errors: Sequence[KeyedError]):
        """Keep them in their order."""
        super().__init__("\n".join(str(error) for error in errors))
        self.errors = tuple(errors)

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle by what it holds."""
        return type(self), (self.errors,)


def check_all(*checks: Callable[[], object]) -> None:
    """Make all `checks`, none of which needs another to pass; raise one `SeveralKeyedError` for those that fail."""
    found: list[KeyedError] = []
    for check in checks:
        try:
            check()
        except KeyedError as error:
            found.append(error)
        except SeveralKeyedError as several:
            found += several.errors
    if found:
        raise found[0] if len(found) == 1 else SeveralKeyedError(found)


@dataclass(frozen=True)
class Unit:
    """Marks a number that carries a unit; `symbol` is that unit in a and U."""

    dimension: str
    symbol: str


def _reader(unit: Unit) -> BeforeValidator:
    """Return the validator that turns a string with units into a number of `unit`."""

    def read(value: Any, info: ValidationInfo) -> Any:
        if not isinstance(value, str):
            return value
        units = (info.context or {}).get("units")
        if units == UNITS_UNKNOWN:
            raise PydanticCustomError(UNITS_UNKNOWN, "the units section is wrong")
        if units is None:
            raise ValueError(f"expected a number in {unit.symbol} (strings need a `units` section), found {value!r}")
        return units.number(value, unit.dimension)

    return BeforeValidator(read, json_schema_input_type=float | str)


_LENGTH, _TIME, _SPEED = Unit("length", "a"), Unit("time", "a/U"), Unit("speed", "U")
_DIFFUSIVITY, _TURNING = Unit("diffusivity", "a U"), Unit("rotational diffusivity", "U/a")

Length = Annotated[float, _LENGTH, _reader(_LENGTH)]
Time = Annotated[float, _TIME, _reader(_TIME)]
Speed = Annotated[float, _SPEED, _reader(_SPEED)]
Diffusivity = Annotated[float, _DIFFUSIVITY, _reader(_DIFFUSIVITY)]
RotationalDiffusivity = Annotated[float, _TURNING, _reader(_TURNING)]  # rad^2 understood


def _whole(value: Any) -> Any:
    # YAML reads 1e4 as a float; as a count it is as good as 10000. Beyond 2^53 floats skip whole numbers.
    if isinstance(value, float) and value.is_integer() and abs(value) <= 2.0**53:
        return int(value)
    return value


def _many(value: Any) -> Any:
    return value if isinstance(value, tuple) else (value,)


Whole = Annotated[int, BeforeValidator(_whole)]
Coordinate = Annotated[Length, Field(ge=-LONGEST, le=LONGEST)]
Point = Annotated[tuple[Coordinate, ...], Field(min_length=2, max_length=3)]
Direction = Annotated[tuple[Annotated[float, Field(ge=-1e9, le=1e9)], ...], Field(min_length=2, max_length=3)]
Radius = Annotated[float, _LENGTH, _reader(_LENGTH), Field(ge=LEAST_RADIUS, le=LARGEST_RADIUS)]
Radii = Annotated[
    tuple[Radius, ...],
    Field(min_length=1),
    BeforeValidator(_many, json_schema_input_type=float | str | list[float | str]),
]


def as_vector(values: Sequence[float], *, key: str, dimensions: int) -> np.ndarray:
    """Return (3,) float64 from three numbers in 3-D; from two, or three with a last of 0, in 2-D."""
    if dimensions == 3 and len(values) != 3:
        raise KeyedError(key, f"expected 3 numbers in three dimensions, found {len(values)}")
    if dimensions == 2 and len(values) == 3 and values[2] != 0.0:
        raise KeyedError(key, f"expected a z component of 0 in two dimensions, found {values[2]:g}")
    return np.array([*values, 0.0][:3])


def unit_vector(values: Sequence[float], *, key: str, dimensions: int) -> np.ndarray:
    """Return the (3,) float64 unit vector along `values`; a zero vector is a `KeyedError`."""
    vector = as_vector(values, key=key, dimensions=dimensions)
    largest = np.abs(vector).max()
    if largest == 0.0:
        raise KeyedError(key, "expected a direction, found the zero vector")
    vector /= largest  # so that the norm neither overflows nor underflows
    return np.asarray(vector / np.linalg.norm(vector))


ContactHeight = Callable[[np.ndarray, np.ndarray], np.ndarray]  # (sines of the pitch, radii) -> least heights, a
