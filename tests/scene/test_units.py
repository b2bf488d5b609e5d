"""Physical units, against values worked out by hand in SI."""

from __future__ import annotations

import subprocess
import sys

import pytest

from porous_swim.core.errors import SceneError
from porous_swim.obstacles.layouts import Single
from porous_swim.scene.scene import Scene
from porous_swim.scene.units import Units, UnitSystem, read_quantity
from porous_swim.swimmers.release import PointRelease

JANUS = UnitSystem.of(Units(length="1.0 um", speed="5.0 um/s", viscosity="0.89 mPa s", temperature="300 K"))
ROUNDING = 1e-12  # relative: a few conversions in double precision


@pytest.mark.parametrize(
    ("text", "dimension", "number"),
    [
        ("3.5 um", "length", 3.5), ("250 nm", "length", 0.25), ("1e-5 m", "length", 10.0), ("2 µm",
        "length", 2.0),
        ("1 s", "time", 5.0), ("0.2 ms", "time", 0.001), ("1 min", "time", 300.0), ("0.5 Hz^-1", "time", 2.5),
        ("10 um/s", "speed", 2.0), ("1 mm/hour", "speed", 1000.0 / 3600.0 / 5.0),
        ("0.25 um^2/s", "diffusivity", 0.05), ("2.5e-13 m**2/s", "diffusivity", 0.05),
        ("0.057 rad^2/s", "rotational diffusivity", 0.0114), ("0.057 1/s", "rotational diffusivity", 0.0114),
        ("0.057 Hz", "rotational diffusivity", 0.0114), ("57000 mrad rad/s", "rotational diffusivity", 11.4),
        # alpha = p/(8 pi mu U a^2) = 0.45e-18 N m/(8 pi 0.89e-3 Pa s 5e-6 m/s 1e-12 m^2)
        ("0.45 pN um", "dipole", 4.023580021986),
        # D = kT/(6 pi mu a) = 4.141947e-21 J/(6 pi 0.89e-3 Pa s 1e-6 m) = 2.46896e-13 m^2/s,
        # over a U = 5e-12 m^2/s
        ("thermal", "diffusivity", 0.0493791265),
    ],
)  # fmt: skip
def test_strings_become_numbers_in_a_and_u(text: str, dimension: str, number: float) -> None:
    # 1e-9: the last two numbers are written to 10 digits
    assert JANUS.number(text, dimension) == pytest.approx(
        number, rel=ROUNDING if dimension != "dipole" and text != "thermal" else 1e-9
    )


@pytest.mark.parametrize(
    ("text", "dimension", "number"),
    [
        # E. coli (Drescher et al., PNAS 108, 10940, 2011): a force of 0.42 pN over 1.9 um
        ("0.42 pN * 1.9 um", "dipole", 0.798), ("0.42pN*1.9um", "dipole", 0.798),
        ("0.42 pN × 1900 nm", "dipole", 0.798),
        ("2 * 3 um", "length", 6.0), ("3 um * 2", "length", 6.0), ("2 um * 3 um * 4 s^-1", "diffusivity", 24.0),
        ("1e6 nm**2/s", "diffusivity", 1.0), ("2 pN*um", "dipole", 2.0),
        ("25 degC", "temperature", 298.15), ("-10 °C", "temperature", 263.15), ("300 K", "temperature", 300.0),
    ],
)  # fmt: skip
def test_products_and_degrees_celsius_are_read(text: str, dimension: str, number: float) -> None:
    assert read_quantity(text, dimension) == pytest.approx(number, rel=ROUNDING)


@pytest.mark.parametrize(
    ("text", "dimension"),
    [("2 * 3", "length"), ("2 um * 3 um", "length"), ("2 um ** 3", "length"), ("2 um * x", "length"),
     ("2 um *", "length"), ("25 degC * 2", "temperature"), ("25 degF", "temperature")],
)  # fmt: skip
def test_a_product_of_another_kind_is_refused(text: str, dimension: str) -> None:
    with pytest.raises(ValueError, match=f"a {dimension}"):
        read_quantity(text, dimension)


def test_nothing_is_colder_than_absolute_zero() -> None:
    with pytest.raises(SceneError, match=r"units\.temperature: expected more than 0, found '-274 degC'"):
        Scene.from_mapping(physical(temperature="-274 degC"))


def test_degrees_of_angle_are_turned_into_radians() -> None:
    assert JANUS.number("1 deg^2/s", "rotational diffusivity") == pytest.approx(
        3.0461741978670857e-4 / 5.0, rel=ROUNDING
    )


@pytest.mark.parametrize(
    "text", ["2 a", "5 U", "1 year", "um", "5", "1 s", "1 foo(", "nan um", "1 + 2 um", "", "3 degC"]
)
def test_what_is_no_length_is_refused(text: str) -> None:
    with pytest.raises(ValueError, match="length"):
        read_quantity(text, "length")


@pytest.mark.parametrize(
    "text", ["0.19 rad/s", "11 deg/s", "2 mrad/s", "1 turn/min", "1 rad^3/s", "1 s/rad^2", "1 rad^2"]
)
def test_a_rate_of_turning_is_no_rotational_diffusivity(text: str) -> None:
    with pytest.raises(
        ValueError, match=r"expected a rotational diffusivity such as `0.19 rad\^2/s` or `0.19 1/s`, found"
    ):
        read_quantity(text, "rotational diffusivity")


@pytest.mark.parametrize(("text", "dimension"), [("5 um rad", "length"), ("5 um rad/s", "speed"), ("1 s/rad", "time")])
def test_an_angle_belongs_to_no_other_quantity(text: str, dimension: str) -> None:
    with pytest.raises(ValueError, match=f"expected a {dimension} such as"):
        read_quantity(text, dimension)


def test_a_scene_names_the_key_of_a_rate_of_turning() -> None:
    noise = {"kind": "brownian", "translational_diffusion": "1 um^2/s", "rotational_diffusion": "0.19 rad/s"}
    with pytest.raises(SceneError, match=r"noise\.rotational_diffusion: .*`0.19 rad\^2/s`.*found '0.19 rad/s'"):
        Scene.from_mapping(physical() | {"noise": noise})


def test_time_follows_from_length_and_speed() -> None:
    assert JANUS.time == pytest.approx(0.2, rel=ROUNDING)


def test_thermal_noise_needs_the_fluid() -> None:
    with pytest.raises(ValueError, match=r"`thermal` needs units\.viscosity and units\.temperature"):
        UnitSystem(length=1.0, speed=5.0).number("thermal", "diffusivity")


def physical(**units: str) -> dict[str, object]:
    return {
        "units": {"length": "2 um", "speed": "4 um/s", **units},
        "swimmers": {
            "count": 1,
            "dipole_strength": 1.0,
            "release": {"kind": "point", "position": ["-80 um", 0, 0]},
        },
        "obstacles": {"layout": "single", "radius": "40 um"},
        "run": {"time_step": "0.5 ms", "duration": "2 s"},
    }


def test_a_scene_in_um_and_s_is_the_scene_in_a_and_u() -> None:
    scene = Scene.from_mapping(physical())
    assert isinstance(scene.obstacles, Single)
    assert isinstance(scene.swimmers.release, PointRelease)
    assert scene.obstacles.radius == pytest.approx(20.0, rel=ROUNDING)
    assert scene.swimmers.release.position == pytest.approx((-40.0, 0.0, 0.0))
    assert scene.run.time_step == pytest.approx(0.001, rel=ROUNDING)
    assert scene.n_steps == 4000
    assert scene.unit_system is not None
    assert (scene.unit_system.length, scene.unit_system.time) == (2.0, 0.5)


@pytest.mark.parametrize(
    ("units", "message"),
    [
        ({"speed": "4 um"}, "units.speed: expected a speed such as `5 um/s`, found '4 um'"),
        ({"length": "0 um"}, "units.length: expected more than 0, found '0 um'"),
        ({"viscosity": "1 K"}, "units.viscosity: expected a viscosity such as `0.89 mPa s`, found '1 K'"),
        ({"lenght": "1 um"}, "units.lenght: unknown key; did you mean `length`?"),
    ],
)
def test_bad_units_are_named(units: dict[str, str], message: str) -> None:
    with pytest.raises(SceneError) as caught:
        Scene.from_mapping(physical(**units))
    assert str(caught.value).startswith(message)


def test_the_resolved_scene_keeps_its_units_beside_plain_numbers() -> None:
    scene = Scene.from_mapping(physical())
    text = scene.to_yaml()
    assert "radius: 20.0" in text
    assert "length: 2 um" in text


def test_pint_is_loaded_only_for_units() -> None:
    code = (
        "import sys, porous_swim.scene.scene as s; s.load_scene('scenes/bullseye.yaml'); assert 'pint' not in "
        "sys.modules;"
        "s.load_scene('scenes/crystal_thermal.yaml'); assert 'pint' in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
