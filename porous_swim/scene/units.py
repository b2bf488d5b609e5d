"""Physical units: from strings such as `10 um` to numbers in a, U and a/U, and back to um and s.

Internally micrometres, seconds, piconewtons and kelvin, in which 1 Pa s is 1 pN s/um^2. Pint is loaded only
when a scene has units. Its own registry reads `a` as years and `U` as enzyme units, hence the small one here.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cache, partial
from math import pi
from typing import Annotated, Any

from pydantic import BeforeValidator, model_validator

from porous_swim.core.parts import KeyedError, Part, check_all

BOLTZMANN = 1.380649e-5  # pN um/K, exact in the SI

_DEFINITIONS = """
pico- = 1e-12 = p-
nano- = 1e-9 = n-
micro- = 1e-6 = µ- = μ- = u-
milli- = 1e-3 = m-
centi- = 1e-2 = c-
kilo- = 1e3 = k-
mega- = 1e6 = M-
femto- = 1e-15 = f-
atto- = 1e-18 = a-
meter = [length] = m = metre
micron = 1e-6 meter
angstrom = 1e-10 meter = Å
second = [time] = s = sec
minute = 60 second = min
hour = 3600 second = h = hr
hertz = 1 / second = Hz
gram = [mass] = g
kelvin = [temperature] = K
radian = [] = rad
degree = 0.017453292519943295 radian = deg
turn = 6.283185307179586 radian
newton = 1000 gram * meter / second ** 2 = N
dyne = 1e-5 newton = dyn
pascal = newton / meter ** 2 = Pa
poise = 0.1 pascal * second = P
joule = newton * meter = J
erg = 1e-7 joule
electron_volt = 1.602176634e-19 joule = eV
"""

_UNIT_OF = {  # what a quantity is measured in here, and an example for messages
    "length": ("um", "`10 um`"),
    "time": ("s", "`0.5 s`"),
    "speed": ("um/s", "`5 um/s`"),
    "viscosity": ("pN s/um^2", "`0.89 mPa s`"),
    "temperature": ("K", "`300 K` or `25 degC`"),
    "diffusivity": ("um^2/s", "`0.25 um^2/s`"),
    "rotational diffusivity": ("rad^2/s", "`0.19 rad^2/s` or `0.19 1/s`"),
    "dipole": ("pN um", "`0.45 pN um` or `0.42 pN * 1.9 um`"),
}
_RANGE = {  # what the units of a scene may be: from a molecule to a whale, in this module's units
    "length": (1e-3, 1e6),
    "speed": (1e-6, 1e9),
    "viscosity": (1e-6, 1e6),
    "temperature": (1e-3, 1e4),
}
_LONGEST = 100  # letters of a quantity: pint's time grows with the square of them
_ANGLES = ("radian", "degree", "turn")  # pint counts them as pure numbers: rad/s would pass for rad^2/s
_QUANTITY = re.compile(r"\s*([-+]?(?:\.[0-9]+|[0-9]+(?:\.[0-9]*)?)(?:[eE][-+]?[0-9]+)?)\s*(\S.*?)?\s*")
_TIMES = re.compile(r"(?<!\*)[*×·](?!\*)(?=\s*[-+.0-9])")  # before a number: `pN*um` and `m**2` are units
_CELSIUS = ("degC", "°C", "celsius")
_FREEZING = 273.15  # K


@cache
def _registry() -> Any:
    import pint

    registry: Any = pint.UnitRegistry(None)
    registry.load_definitions(_DEFINITIONS.strip().splitlines())
    return registry


def read_quantity(text: str, dimension: str) -> float:
    """Return `text`, such as `10 um`, as a number in this module's unit of `dimension`; else `ValueError`.

    Products such as `0.42 pN * 1.9 um` are multiplied; a temperature may be in `degC`.
    """
    unit, example = _UNIT_OF[dimension]
    if len(text) > _LONGEST:
        raise ValueError(f"expected a {dimension} with its unit such as {example}, found {len(text):,} letters")
    factors = [_QUANTITY.fullmatch(factor) for factor in _TIMES.split(text)]
    if None in factors or not any(factor and factor[2] for factor in factors):
        raise ValueError(f"expected a {dimension} with its unit such as {example}, found {text!r}")
    numbers, units = zip(*((float(factor[1]), factor[2]) for factor in factors if factor), strict=True)
    if dimension == "temperature" and units in [(name,) for name in _CELSIUS]:
        return float(numbers[0] + _FREEZING)
    found = _registry().Quantity(1.0)
    for number, name in zip(numbers, units, strict=True):
        try:
            found = found * _registry().Quantity(number, name or "")
        except Exception as error:  # pint raises half a dozen unrelated kinds on nonsense
            raise ValueError(
                f"{name!r} is not a unit that is known here; a {dimension} is such as {example}"
            ) from error
    if not found.is_compatible_with(unit) or _angles(found) not in (0, _angles(_registry().Quantity(unit))):
        raise ValueError(f"expected a {dimension} such as {example}, found {text!r}")
    return float(found.to(unit).magnitude)


def _angles(quantity: Any) -> float:
    """Return the power of angle in the unit of `quantity`."""
    return float(sum(power for name, power in quantity.unit_items() if name.endswith(_ANGLES)))


def _text(dimension: str) -> BeforeValidator:
    def read(value: Any) -> Any:
        if not isinstance(value, str):
            raise ValueError(f"expected a {dimension} with its unit such as {_UNIT_OF[dimension][1]}, found {value!r}")
        return value

    return BeforeValidator(read)


class Units(Part):
    """What a, U and the fluid are in the laboratory; results then say what a and a/U are in um and s."""

    length: Annotated[str, _text("length")]
    """Half-length a of the swimmer, a string such as `1.0 um`; from 1 nm to 1 m."""
    speed: Annotated[str, _text("speed")]
    """Swimming speed U, a string such as `5.0 um/s`; from 1e-6 to 1e9 um/s."""
    viscosity: Annotated[str, _text("viscosity")] | None = None
    """Viscosity mu of the fluid, a string such as `0.89 mPa s`, from 1e-6 to 1e6 Pa s; for `dipole` and `thermal`."""
    temperature: Annotated[str, _text("temperature")] | None = None
    """Temperature of the fluid, a string such as `300 K` or `25 degC`, from 1e-3 to 1e4 K; for `thermal`."""

    @model_validator(mode="after")
    def _all_positive(self) -> Units:
        given = [(key, getattr(self, key)) for key in type(self).model_fields if getattr(self, key) is not None]
        check_all(*(partial(_check_range, key, text) for key, text in given))
        return self


def _check_range(dimension: str, text: str) -> None:
    """Raise a `KeyedError` where a key of `Units` is not read, or beyond what a laboratory has."""
    try:
        value = read_quantity(text, dimension)
    except ValueError as error:
        raise KeyedError(dimension, str(error)) from None
    least, most = _RANGE[dimension]
    if not value > 0.0:
        raise KeyedError(dimension, f"expected more than 0, found {text!r}")
    if not least <= value <= most:
        unit = _UNIT_OF[dimension][0]
        raise KeyedError(dimension, f"expected {least:g} to {most:g} {unit}, found {text!r}")


@dataclass(frozen=True)
class UnitSystem:
    """The laboratory values of the scene's units."""

    length: float  # a in um
    speed: float  # U in um/s
    viscosity: float | None = None  # Pa s
    temperature: float | None = None  # K

    @classmethod
    def of(cls, units: Units) -> UnitSystem:
        """Return the system that a `units` section describes."""
        given = {key: text for key, text in units.model_dump().items() if text is not None}
        return cls(**{key: read_quantity(text, key) for key, text in given.items()})

    @property
    def time(self) -> float:
        """Return a/U in s."""
        return self.length / self.speed

    def number(self, text: str, dimension: str) -> float:
        """Return a string with units as a number in a, U and a/U; `dimension` as in this module's table.

        A diffusivity may be `thermal`, kT/(6 pi mu a) whatever the shape. A dipole p becomes alpha = p/(8 pi mu U a^2).
        """
        if dimension == "diffusivity" and text == "thermal":
            return self.thermal_diffusion()
        return read_quantity(text, dimension) / self._scale(dimension)

    def thermal_diffusion(self) -> float:
        """Return the Stokes-Einstein diffusivity kT/(6 pi mu a) of a sphere of radius a, in a U."""
        if self.viscosity is None or self.temperature is None:
            raise ValueError("`thermal` needs units.viscosity and units.temperature")
        in_um = BOLTZMANN * self.temperature / (6.0 * pi * self.viscosity * self.length)
        return in_um / (self.length * self.speed)

    def _scale(self, dimension: str) -> float:
        if dimension == "dipole":
            if self.viscosity is None:
                raise ValueError("a dipole with units needs units.viscosity")
            return 8.0 * pi * self.viscosity * self.speed * self.length**2
        return {
            "length": self.length,
            "time": self.time,
            "speed": self.speed,
            "diffusivity": self.length * self.speed,
            "rotational diffusivity": self.speed / self.length,
        }[dimension]
