"""A job's numbers in the unit that people are used to: each is refused, and the right one told."""

import re
import tomllib
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest

from tunneller_lib.job import WrongJob, read_job, reader
from tunneller_lib.job.tables import OTHERS, Size, read_table

READS = ["notebooks/reference.toml"]

ROOT = Path(__file__).resolve().parents[1]
TEXT = (ROOT / "notebooks" / "reference.toml").read_text()
# The reference with all that it only names, and pieces of a section, as numbers of a usual size.
NAMED = tomllib.loads(re.sub(r"^# (?=\[|[a-z_R]+ = )", "", TEXT, flags=re.M).replace(
    "[section]", "[section]\npieces = [{y = 0.5, z = -0.4, radius = 0.5, start = 3.1, sweep = 1.5, "
    "heading = -1.5, length = 0.4}]"))  # fmt: skip
TABLES = {field.name: getattr(reader, field.name.upper(), {}) for field in fields(reader.Job)}
TABLES["section"] = {
    key: size for _, sizes in reader.SHAPES.values() for key, size in sizes.items()
}
PIECES = {key: size for _, sizes in reader.PIECES.values() for key, size in sizes.items()}
NUMBERS = [
    *((table, key) for table, sizes in TABLES.items() for key in sizes),
    *(("pieces", key) for key in PIECES),
]
NUMBERS = [
    (table, key, (TABLES | {"pieces": PIECES})[table][key])
    for table, key in NUMBERS
    if isinstance((TABLES | {"pieces": PIECES})[table][key], Size)
]
# What nobody gives in another unit: a loop's gains and a task's work go by seconds everywhere.
NO_OTHER = {"gain", "integral", "operations"}
# What a unit is of another, found apart from the library: of the number that is wanted.
IN = {
    "mm": lambda x: x * 1000, "mm/s": lambda x: x * 1000, "mm/s^2": lambda x: x * 1000,
    "m/min": lambda x: x * 60, "l": lambda x: x * 1000, "cm^3": lambda x: x * 100**3,
    "l/min": lambda x: x * 1000 * 60, "m^3/h": lambda x: x * 3600, "ms": lambda x: x * 1000,
    "l/min/bar": lambda x: x * 1000 * 60 * 100_000, "1/min": lambda x: x * 60,
    "t": lambda x: x / 1000, "kN m": lambda x: x / 1000, "bar": lambda x: x / 100_000,
    "MPa": lambda x: x / 10**6,
    "GPa": lambda x: x / 10**9, "kW": lambda x: x / 1000, "MJ/m^3": lambda x: x / 10**6,
    "kWh/m^3": lambda x: x / (1000 * 3600), "%": lambda x: x * 100,
    "counts a turn": lambda x: 2 * np.pi / x, "bits": lambda x: np.log2(2 * np.pi / x),
}  # fmt: skip


def usual(table, key):
    """Return the reference's number of a key, in SI units."""
    given = NAMED["section"]["pieces"][0] if table == "pieces" else NAMED[table]
    number = given[key] if key in given else np.radians(given[f"{key}_deg"])
    # What the reference leaves at zero, or only names, as it would be if there were any.
    return number or {"height": -0.36, "pitch": 0.1, "yaw": 0.1, "encoder": 2 * np.pi / 2**16}[key]


def told(table, key, value, size):
    """Return what is said of a table that holds one number alone."""
    with pytest.raises(ValueError) as refused:
        read_table(table, {key: value}, {key.removesuffix("_deg"): size})
    assert not isinstance(refused.value, WrongJob)
    return str(refused.value)


@pytest.mark.parametrize(("table", "key", "size"), NUMBERS)
def test_every_number_of_the_reference_is_plausible(table, key, size):
    number = usual(table, key) if key not in NO_OTHER else 10.0
    assert read_table(table, {key: number}, {key: size}) == {key: number}
    # and so it is of a machine a third or three times as large
    for scale in (1 / 3, 3) if size.unit == "m" else ():
        assert read_table(table, {key: scale * number}, {key: size})


@pytest.mark.parametrize(("table", "key", "size"), [
    number for number in NUMBERS if number[2].unit != "rad" or number[2].others
])  # fmt: skip
def test_every_number_in_another_unit_is_refused_and_the_right_one_told(table, key, size):
    others = OTHERS.get(size.unit, {}) if size.others is None else dict(size.others)
    assert others or key in NO_OTHER
    number = usual(table, key) if others else 0.0
    for other in others:
        given = IN[other](number)
        said = told(table, key, float(given), size)
        assert said.startswith(f"[{table}] {key}: must be ") and f"; got {given:g}" in said
        meant = re.findall(
            r"[Ii]f(?: that is)? in ([^,]+), (?:it is )?(\S+) ([^;]+?)[;.](?= |$)", said
        )
        right = [float(value) for its, value, unit in meant if (unit, its) == (size.unit, other)]
        assert right == [pytest.approx(number, rel=1e-5)], said
        assert all(size.least <= abs(float(value)) <= size.most for _, value, _ in meant)


@pytest.mark.parametrize(("table", "key", "size"), [
    number for number in NUMBERS if number[2].unit == "rad" and not number[2].others
])  # fmt: skip
def test_every_angle_of_ten_degrees_and_more_without_its_suffix_is_told_the_name(table, key, size):
    number = np.degrees(abs(usual(table, key)))
    for value in (number, -number, 10.0) if number > 5 else (10.0,):
        said = told(table, key, float(value), size)
        assert said.endswith(f"; got {value:g}. In degrees its name is {key}_deg.")
        assert read_table(table, {f"{key}_deg": value}, {key: size}) == {
            key: pytest.approx(np.radians(value))
        }


@pytest.mark.parametrize(("line", "said"), [
    ("step = 5e-3", "[plan] step: must be at most 0.3 m; got 5. If that is in mm, it is 0.005 m."),
    ("power = 3e3", "[limits] power: must be from 20 to 1e+07 W; got 3. "
     "If that is in kW, it is 3000 W."),
    ("energy = 20e6", "[ground] energy: must be from 1000 to 1e+10 J/m^3; got 20. "
     "If that is in MJ/m^3, it is 2e+07 J/m^3; if in kWh/m^3, 7.2e+07 J/m^3."),
    ("# supply = 160e5", "[hydraulics] supply: must be from 100000 to 1e+08 Pa; got 160. "
     "If that is in bar, it is 1.6e+07 Pa."),
    ("count_deg = 0.0054931640625", "[plan] count_deg: must be from 5.72958e-08 to 5.72958 "
     "degrees; got 65536. If that is in counts a turn, it is 0.00549316 degrees."),
    ("feed = 0.1 ", "[limits] feed: must be from 0.0001 to 1 m/s; got 3. "
     "If that is in mm/s, it is 0.003 m/s; if in m/min, 0.05 m/s."),
])  # fmt: skip
def test_job_in_usual_units_is_told_what_is_meant(tmp_path, line, said):
    name = line.removeprefix("# ").partition(" ")[0]
    given = re.search(r"got (\S+)\. ", said)[1]
    assert TEXT.count(line) == 1
    text = TEXT.replace(line, f"{name} = {given} ")
    if line.startswith("# "):
        text = text.replace("# [hydraulics]", "[hydraulics]")
    (tmp_path / "job.toml").write_text(text)
    with pytest.raises(ValueError) as refused:
        read_job(tmp_path / "job.toml")
    assert str(refused.value) == said


@pytest.mark.parametrize(("given", "suggested"), [
    ("halfangle_deg", "half_angle_deg"), ("half_angel", "half_angle"), ("halfangle", "half_angle"),
    ("length_deg", "length"), ("lenght", "length"), ("lenght_deg", "length"),
])  # fmt: skip
def test_suggested_name_keeps_the_unit_of_the_one_that_was_given(given, suggested):
    sizes = {"half_angle": Size("rad"), "length": Size("m"), "tip_radius": Size("m")}
    with pytest.raises(WrongJob, match=rf"isn't known; '{suggested}' is meant, perhaps\.$"):
        read_table("mill", {given: 12}, sizes)


@pytest.mark.parametrize("name", [key for _, key, size in NUMBERS if size.unit == "rad"])
def test_every_angle_given_in_degrees_with_a_letter_amiss_is_told_its_name_in_degrees(name):
    sizes = {key: size for _, key, size in NUMBERS}
    with pytest.raises(WrongJob, match=rf"; '{name}_deg' is meant, perhaps\.$"):
        read_table("any", {f"{name[0]}{name}_deg": 1.0}, sizes)


def test_limits_of_plausible_sizes_pass_and_what_is_next_to_them_is_refused():
    size = Size("W", 20.0, 1e7)
    for value in (20, 20.0, 1e7, 0, -0.0, -5.0, np.inf, np.nan):
        read_table("limits", {"power": value}, {"power": size})
    for value in (np.nextafter(20, 0), np.nextafter(1e7, 1e8), 5e-324, 1e300, 10**300):
        assert told("limits", "power", value, size).startswith("[limits] power: must be from 20 to")
    turned = Size("rad", most=3.2)
    for value in (3.2, -3.2):
        read_table("machine", {"phi_max": value}, {"phi_max": turned})
        assert " in size" in told("machine", "phi_max", -3.3, turned)
