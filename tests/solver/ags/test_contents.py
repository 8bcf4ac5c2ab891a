"""Tests and readings of a SYNTHETIC file are found as they were put in."""

from __future__ import annotations

import math

import pytest

from geoswarm.solver.ags.contents import Contents, chosen, contents_of, entries
from geoswarm.solver.ags.monitoring import csv_of
from geoswarm.solver.ags.reading import read_ags
from geoswarm.solver.ags.shear_strength import strength_of
from geoswarm.solver.ags.tables import AgsError
from tests.solver.ags import synthetic
from tests.solver.ags.synthetic import COHESION, FIRST, PHI, STRESSES, content, group, keyed, void_ratio


def contents(**other: str) -> Contents:
    return contents_of(read_ags(content(**other), "synthetic.ags"))


def compression(rows: list[list[object]], **other: tuple[str, str]) -> dict[str, str]:
    """CONG with one test, and the rows of its CONS."""
    columns = {"CONG_HIGT": ("mm", "2DP"), **other}
    values = [20.0, *("2.70", "1.20")[: len(other)]]
    increments = keyed(CONS_INCN=("", "X"), CONS_IVR=("", "3DP"), CONS_INCF=("kPa", "0DP"), CONS_INCE=("", "3DP"))
    return {
        "CONG": group("CONG", keyed(**columns), [[*FIRST, *values]]),
        "CONS": group("CONS", increments, [[*FIRST, *row] for row in rows]),
    }


def test_compression_tests() -> None:
    (name, first), (other, second) = contents().compression
    assert (name, other) == ("BH1/3/1/4.60", "BH2/5/1/6.10")
    assert (first.height, first.void_ratio, first.unloading) == (pytest.approx(0.01925), 1.2, 2)
    assert tuple(one.stress for one in first.increments) == STRESSES
    assert [one.void_ratio for one in first.increments] == pytest.approx(void_ratio(STRESSES), rel=1e-11)
    assert second.void_ratio == 1.0
    assert first.notes == second.notes == ()


def test_increments_out_of_order_without_stress_or_void_ratio() -> None:
    rows: list[list[object]] = [
        ["2", 0.90, 50.0, 0.80],
        ["1", 1.00, 25.0, 0.90],
        ["3", 0.79, 100.0, ""],
        ["4", "", 0.0, 0.85],
    ]
    ((_, test),) = contents(**compression(rows)).compression
    assert [(one.number, one.stress, one.void_ratio) for one in test.increments] == [
        ("1", 25.0, 0.90),
        ("2", 50.0, 0.80),
        ("3", 100.0, None),
    ]
    told = "; ".join(test.notes)
    for words in (
        "not in the order of CONS_INCN",
        "increment 3 begins at the void ratio 0.79, and the one before has ended at 0.8",
        "increment 4 ends at no stress",
        "increment 3 has no void ratio",
        "there is no unloading",
    ):
        assert words in told


def test_the_void_ratio_at_the_beginning_may_follow_from_densities() -> None:
    densities = {"CONG_PDEN": ("Mg/m3", "XN"), "CONG_DDEN": ("Mg/m3", "2DP")}
    ((_, test),) = contents(**compression([["1", "", 25.0, 0.9]], **densities)).compression
    assert test.void_ratio == pytest.approx(2.70 / 1.20 - 1.0, rel=1e-14)
    assert "CONG_PDEN (2.7) / CONG_DDEN (1.2) - 1" in test.void_ratio_from


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        ([["1", 1.0, "", 0.9]], "heading CONS_INCF: the empty cell: a number of at least 0 kPa is accepted"),
        ([["1", 1.0, 25.0, "-0.1"]], "heading CONS_INCE: '-0.1': a number above 0 is accepted"),
        ([["1", "", 25.0, 0.9]], "a void ratio above 0, there or as CONS_IVR of the first increment"),
        ([["1", 1.0, 25.0, ""]], "heading CONS_INCE: the empty cell: a void ratio above 0"),
        ([["1", 1.0, 25.0, 0.9], ["1", 0.9, 50.0, 0.8]], "heading CONS_INCN: '1': give each increment once"),
    ],
)
def test_what_is_wrong_with_a_compression_test_is_reported(rows: list[list[object]], message: str) -> None:
    found = contents(**compression(rows))
    assert not found.compression
    with pytest.raises(AgsError, match=message):
        chosen(found, ["BH1/3/1"])


def test_hydraulic_cells_are_compression_tests_too() -> None:
    names = keyed(ESCG_HIGT=("mm", "2DP"), ESCG_LOAD=("", "X"), ESCG_IVR=("", "3DP"))
    steps = keyed(ESCT_INCN=("", "X"), ESCT_INCF=("kPa", "0DP"), ESCT_VRE=("", "3DP"))
    cells = {
        "ESCG": group("ESCG", names, [[*FIRST, 100.0, "Equal", 0.8]]),
        "ESCT": group("ESCT", steps, [[*FIRST, "1", 100.0, 0.75], [*FIRST, "2", 50.0, 0.76]]),
    }
    ((_, test),) = contents(CONG="", CONS="", **cells).compression
    assert (test.groups, test.height, test.void_ratio, test.unloading) == ("ESCG/ESCT", 0.1, 0.8, 1)
    cells["ESCG"] = cells["ESCG"].replace("Equal", "Free, triaxial")
    assert "which is not a compression" in contents(CONG="", CONS="", **cells).without[0][1]


def test_details_belong_to_a_test_that_is_there_once() -> None:
    with pytest.raises(AgsError, match="group CONS needs the group CONG, which is missing"):
        contents(CONG="")
    rows = compression([["1", 1.0, 25.0, 0.9]])
    again = rows["CONG"].rstrip() + "\r\n" + rows["CONG"].rstrip().splitlines()[-1] + "\r\n"
    assert contents(**{**rows, "CONG": again}).without == ()  # the same row twice says one thing
    head, _, last = again.rpartition('"20"')
    twice = contents(**{**rows, "CONG": f'{head}"19"{last}'})
    assert twice.compression == ()
    assert "group CONG has the specimen BH1/4.50/3/U/1/4.60 of line" in twice.without[0][1]
    orphan = contents(**{**rows, "CONS": rows["CONS"].replace('"1","4.60"', '"9","4.60"')}).without
    assert "group CONS has the specimen BH1/4.50/3/U/9/4.60, which is not in group CONG" in orphan[0][1]
    assert "group CONG has the specimen BH1/4.50/3/U/1/4.60 without readings in group CONS" in orphan[1][1]
    (alone,) = contents(**{**rows, "CONS": ""}).without
    assert alone[1] == orphan[1][1]
    same = contents(**{**rows, "CONS": rows["CONS"].replace('"4.50"', '"4.5"').replace('"4.60"', '"4.600"')})
    assert [id for id, _ in same.compression] == ["BH1/3/1/4.60"]
    assert same.without == ()


def test_rows_without_a_cell_of_their_own_are_passed_over() -> None:
    kept = contents().shear
    empty = '"DATA","BH2","9.00","7","U","","3","9.10"'
    tests = content().decode()
    group, _, after = tests.partition('"GROUP","TRIT"')
    assert after
    lines = after.split("\r\n")
    width = lines[1].count(",")
    at = next(place for place, line in enumerate(lines) if line.startswith('"DATA"'))
    lines.insert(at, empty + ',""' * (width - 7))
    found = contents_of(read_ags((group + '"GROUP","TRIT"' + "\r\n".join(lines)).encode(), "a.ags"))
    assert [test for _, test in found.shear] == [test for _, test in kept]


def test_the_more_precise_of_two_void_ratios_counts() -> None:
    rows = compression([["1", 0.366, 50.0, 0.36], ["2", 0.359, 98.0, 0.35], ["3", 0.346, 198.0, 0.33]])
    rows["CONS"] = rows["CONS"].replace('"0DP","3DP"', '"0DP","2DP"')
    ((_, test),) = contents(**rows).compression
    assert [one.void_ratio for one in test.increments] == [0.359, 0.346, 0.33]
    assert not any("begins at the void ratio" in note for note in test.notes)
    rows = compression([["1", 0.366, 50.0, 0.36], ["2", 0.351, 98.0, 0.35]])
    rows["CONS"] = rows["CONS"].replace('"0DP","3DP"', '"0DP","2DP"')
    ((_, other),) = contents(**rows).compression
    assert [one.void_ratio for one in other.increments] == [0.36, 0.35]
    assert any("increment 2 begins at the void ratio 0.351" in note for note in other.notes)


@pytest.mark.parametrize(
    ("row", "done"),
    [
        ('"DATA","BH1","Soft CLAY.\r\nRootlets, to 0.3 m."', "mended"),
        ('"DATA","BH1","with 2" gravel, firm"', "mended"),
        ('"DATA","BH1","Soft CLAY', "left out"),
        ('"DATA","BH1","Soft CLAY","and more"', "left out"),
    ],
)
def test_a_damaged_remark_costs_that_remark(row: str, done: str) -> None:
    remarks = f'"GROUP","GEOL"\r\n"HEADING","LOCA_ID","GEOL_DESC"\r\n{row}\r\n"DATA","BH2","SAND"\r\n\r\n'
    file = read_ags(remarks.encode() + content(), "a.ags")
    assert len(file.groups["GEOL"].rows) == (2 if done == "mended" else 1)
    found = contents_of(file)
    assert [id for id, _ in found.compression] == [id for id, _ in contents().compression]
    (damaged,) = [entry for entry in entries(found) if entry.kind == "damaged row"]
    assert damaged.id == "GEOL"
    assert damaged.what.startswith("a.ags line 3: ")
    assert damaged.what.endswith(f"the row of group GEOL is {done}")


def test_shear_tests_give_the_strength_that_they_were_made_with() -> None:
    found = contents()
    (_, drained), (_, undrained), (_, quick) = found.shear
    assert (drained.drainage, undrained.drainage, quick.drainage) == ("drained", "undrained", "total")
    for tests in ([drained], [undrained], [drained, undrained]):
        strength = strength_of(tests)
        assert strength.cohesion == pytest.approx(COHESION, rel=1e-9)
        assert strength.friction_angle == pytest.approx(PHI, rel=1e-10)
    assert drained.failures[0].strain == pytest.approx(0.05, rel=1e-14)
    assert drained.failures[0].rate == pytest.approx(0.015 * 24.0, rel=1e-14)
    assert drained.laboratory == (4.0, 28.5)
    assert [one.deviator_stress for one in quick.failures] == [120.0]
    told = {entry.id: entry.what for entry in entries(found)}
    assert "Mohr circles: c' 5 kPa, phi' 28 degree" in told["BH1/3/2/4.70"]
    assert "laboratory: c' 4 kPa, phi' 28.5 degree" in told["BH1/3/2/4.70"]
    assert told["BH2/7/3/9.10"] == "1 specimen at failure; undrained shear strength 60 kPa"


def test_an_unknown_kind_of_shear_test_is_reported() -> None:
    found = contents(TREG=synthetic.groups()["TREG"].replace('"CD"', '"XX"'))
    with pytest.raises(AgsError, match=r"group TREG, heading TREG_TYPE: 'XX': one of CADC, .* is accepted"):
        chosen(found, ["BH1/3/2"])


def test_readings_of_instruments_are_in_the_order_of_time() -> None:
    (_, pressure), (_, level) = contents().readings
    assert (pressure.instrument, pressure.quantity, pressure.unit) == ("BH3/P1", "PRES", "kPa")
    assert pressure.days == (0.0, 0.75, 10.0)
    assert pressure.values == (12.0, 14.5, 20.25)
    assert [text for _, text in pressure.skipped] == ["DRY"]
    assert level.values == (3.214,)
    lines = csv_of(pressure, "synthetic.ags").decode().splitlines()
    assert lines[1:3] == ["time [day],PRES [kPa],moment", "0.0,12.0,2026-03-01T12:00:00"]


@pytest.mark.parametrize(
    ("form", "moment"),
    [
        ("yyyy-mm-dd", "2026-03-02"),
        ("dd/mm/yyyy", "02/03/2026"),
        ("dd/mm/yyyy hh:mm", "02/03/2026 06:00"),
        ("yyyy-mm-ddThh:mm:ss.sss(+hh:mm)", "2026-03-02T06:00:00.250+01:00"),
    ],
)
def test_moments_are_in_the_form_of_their_column(form: str, moment: str) -> None:
    text = synthetic.groups()["MOND"].replace("yyyy-mm-ddThh:mm:ss", form)
    for old in ("2026-03-02T06:00:00", "2026-03-01T12:00:00", "2026-03-05T12:00:00", "2026-03-11T12:00:00"):
        text = text.replace(old, moment)
    (_, pressure), _ = contents(MOND=text).readings
    assert {one.strftime("%d.%m.%Y") for one in pressure.moments} == {"02.03.2026"}


def test_a_reading_without_a_moment_is_reported() -> None:
    text = synthetic.groups()["MOND"].replace("2026-03-05T12:00:00", "spring")
    with pytest.raises(AgsError, match="heading MOND_DTIM: 'spring': a moment as yyyy-mm-ddThh:mm:ss is accepted"):
        contents(MOND=text)


def test_ids_choose_what_they_stand_for_and_what_is_below() -> None:
    found = contents()
    assert [name for name, _ in chosen(found, ["BH1"]).compression] == ["BH1/3/1/4.60"]
    assert [name for name, _ in chosen(found, ["BH1/3/1/4.60", "BH2/5"]).compression] == [
        "BH1/3/1/4.60",
        "BH2/5/1/6.10",
    ]
    assert len(chosen(found, ["BH3/P1"]).readings) == 2
    with pytest.raises(AgsError, match=r"'BH' is not an ID in this file.*accepted are BH1/3/1/4.60"):
        chosen(found, ["BH"])


def test_void_ratios_of_the_synthetic_file_have_their_slopes() -> None:
    found = void_ratio(STRESSES)
    assert (found[5] - found[6]) / math.log10(2.0) == pytest.approx(synthetic.CC, rel=1e-12)
    assert (found[8] - found[7]) / math.log10(4.0) == pytest.approx(synthetic.CS, rel=1e-12)
