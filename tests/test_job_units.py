"""A job's numbers in the unit that people are used to: each is refused, and the right one told."""

import re
import tomllib
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest

from tests.examples.job import _JOB as COARSE
from tunneller_lib.job import WrongJob, read_job, reader
from tunneller_lib.job.results import summarise
from tunneller_lib.job.tables import OTHERS, Size, read_table
from tunneller_lib.ream.cutting import simulate
from tunneller_lib.removal import DexelGrid

ROOT = Path(__file__).resolve().parents[1]
TEXT = (ROOT / "tunneller_lib" / "job" / "reference.toml").read_text()
# The reference with all that it only names, and pieces of a section, as numbers of a usual size.
NAMED = tomllib.loads(re.sub(r"^# (?=\[|[a-z_R]+ = )", "", TEXT, flags=re.M).replace(
    "[section]", "[section]\npieces = [{y = 0.5, z = -0.4, radius = 0.5, start = 3.1, sweep = 1.5, "
    "heading = -1.5, length = 0.4}]"))  # fmt: skip
TABLES = {field.name: getattr(reader, field.name.upper(), {}) for field in fields(reader.Job)}
for table, kinds in (("section", reader.SHAPES), ("pieces", reader.PIECES)):
    TABLES[table] = {key: size for _, sizes in kinds.values() for key, size in sizes.items()}
NUMBERS = [
    (table, key, size)
    for table, sizes in TABLES.items()
    for key, size in sizes.items()
    if isinstance(size, Size)
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


@pytest.mark.parametrize(("given", "suggested"), [
    ("halfangle_deg", "half_angle_deg"), ("halfangle", "half_angle"), ("lenght_deg", "length"),
])  # fmt: skip
def test_suggested_name_keeps_the_unit_of_the_one_that_was_given(given, suggested):
    sizes = {"half_angle": Size("rad"), "length": Size("m"), "tip_radius": Size("m")}
    with pytest.raises(WrongJob, match=rf"isn't known; '{suggested}' is meant, perhaps\.$"):
        read_table("mill", {given: 12}, sizes)


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


def job_of(path, *changes):
    """Return the job of the examples with lines put in the place of others."""
    text = COARSE.read_text(encoding="utf-8")
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    path.write_text(text, encoding="utf-8")
    return read_job(path)


def test_litres_of_a_cut_are_those_that_its_ground_has_lost(tmp_path):
    job = job_of(tmp_path / "job.toml")
    cut = simulate(job.planned, *job.axes, shape=(40, 60), thickness=0.3)
    assert cut.plunged > 0.01 * cut.removed.sum() > 0
    lines, left = cut.wall.lines, cut.wall
    begins = job.planned.circuit.section.ray(np.arctan2(lines.sin, lines.cos))
    lost = DexelGrid(lines, begins, left.high.max(axis=0)).volume - left.volume
    assert summarise(job, cut)["removed_m3"] == pytest.approx(lost, rel=1e-9)


def test_a_job_in_ground_asks_for_the_share_of_its_valves_that_the_reference_says(tmp_path):
    [said] = re.findall(r"^# valve = (\S+)", TEXT, re.MULTILINE)
    oily = ('plant = "T0"', 'plant = "T3"'), ("feed = 1.0", "feed = 0.1")
    ground = "power = 3e3\n[ground]\nenergy = 20e6\npick_speed = 2.0\nnormal = 0.5\n"
    usual, more = (
        job_of(tmp_path / "job.toml", *oily, ("acceleration = 20\n", f"acceleration = 1\n{line}"
                                              + ground)).planned.limits
        for line in ("", "valve = 0.9\n")
    )  # fmt: skip
    assert usual.valve == float(said) == 0.8 and more.valve == 0.9
    assert usual.flow == 1.5e-4  # m^3/s, the pump's
