"""Files in the AGS 4 format over HTTP: what they hold, the problem they make, and what is said of broken ones."""

from __future__ import annotations

import asyncio
from pathlib import Path
from typing import Any

import pytest

from geoswarm.api.compute.middleware import is_compute
from geoswarm.client import AsyncClient, Client, HttpError
from tests.api.conftest import API, App, LiveServer
from tests.solver.ags.synthetic import COHESION, PHI, STRESSES, content, groups, void_ratio

LIST, PROBLEM = f"{API}/measurements/ags", f"{API}/measurements/ags/problem"


def listed(app: App, **other: str) -> list[dict[str, Any]]:
    answer = app.post(LIST, params={"name": "synthetic.ags"}, content=content(**other))
    assert answer.status_code == 200, answer.text
    items: list[dict[str, Any]] = answer.json()["items"]
    return items


def made(app: App, *specimens: str, **query: Any) -> dict[str, Any]:
    asked = {"name": "synthetic.ags", "specimen": list(specimens), **query}
    answer = app.post(PROBLEM, params=asked, content=content())
    assert answer.status_code == 200, answer.text
    found: dict[str, Any] = answer.json()
    return found


def test_the_list_says_what_can_be_taken_and_what_not(app: App) -> None:
    entries = {(one["id"], one["kind"]): one for one in listed(app)}
    assert entries["BH1/3/1/4.60", "oedometer (CONG/CONS)"] == {
        "id": "BH1/3/1/4.60",
        "kind": "oedometer (CONG/CONS)",
        "what": "9 increments of 12 to 800 kPa, e0 1.2, 2 of them unload",
        "location": "BH1",
        "depth": "4.60",
        "count": 9,
        "use": "problem",
        "why": "",
    }
    uses = {one["use"] for one in entries.values()}
    assert uses == {"problem", "readings", "nothing"}
    for one in entries.values():
        assert bool(one["why"]) == (one["use"] == "nothing")
    assert entries["BH3/P1", "monitoring PRES (MOND)"]["what"] == "3 readings in kPa, 2026-03-01 to 2026-03-11"
    assert entries["BH3/P1", "monitoring LEV (MOND)"]["what"] == "1 reading in m, 2026-03-01"
    assert "UU, total stresses" in entries["BH2/7/3/9.10", "triaxial UU (TRIG/TRIT)"]["why"]
    assert "CONG_TYPE is SWELL" in entries["BH2/7/1/9.05", "not usable"]["why"]


def test_a_test_with_a_mistake_leaves_the_others(app: App) -> None:
    items = listed(app, TRET=groups()["TRET"].replace('"TRET_DEVF"', '"TRET_XXXX"'))
    by_use = {use: [one["id"] for one in items if one["use"] == use] for use in ("problem", "nothing")}
    assert by_use["problem"] == ["BH1/3/1/4.60", "BH2/5/1/6.10"]
    (wrong,) = (one for one in items if one["id"] == "BH1/3/2/4.70")
    assert "group TRET has no heading TRET_DEVF; a number above" in wrong["why"]


def test_an_oedometer_test_becomes_a_problem_with_its_readings(app: App) -> None:
    answer = made(app, "BH1/3/1/4.60")
    problem = answer["problem"]
    assert answer["specimens"] == ["BH1/3/1/4.60"]
    assert problem["forward_model"]["kind"] == "oedometer"
    (readings,) = problem["observations"]
    assert "file" not in readings
    assert readings["points"]["x"] == list(range(1, len(STRESSES) + 1))
    assert readings["points"]["y"] == pytest.approx(void_ratio(STRESSES), rel=1e-11)
    assert readings["notes"][0].startswith("synthetic.ags: CONG/CONS of BH1/3/1/4.60")
    assert set(answer["notes"]) <= set(readings["notes"])
    draft = app.post(f"{API}/problems/read", json=problem).json()
    assert (draft["valid"], draft["issues"]) == (True, [])


def test_what_the_file_does_not_say_can_be_given(app: App) -> None:
    answer = made(app, "BH1/3/1/4.60", material="soft_soil_creep", stage_duration=2.0, initial_stress=3.0)
    section = answer["problem"]["forward_model"]
    assert (section["material"], section["initial_stress"]) == ("soft_soil_creep", 3.0)
    assert {stage["duration"] for stage in section["stages"]} == {2.0}
    assert any("48 h are assumed for each (stage_duration)" in note for note in answer["notes"])


def test_notes_and_messages_name_fields_where_they_are_asked_for(app: App) -> None:
    notes = made(app, "BH1/3/1/4.60", words="fields")["notes"]
    assert any("24 h are assumed for each (“Duration of an increment”)" in note for note in notes)
    assert any(note.endswith("(“Initial stress” gives another)") for note in notes)
    asked = {"name": "a.ags", "specimen": ["BH1/3/1/4.60"], "initial_stress": 500.0, "words": "fields"}
    refused = app.post(PROBLEM, params=asked, content=content()).json()["issues"][0]["message"]
    assert refused.startswith("“Initial stress” must be above 0 and below 12 kPa")
    refused = app.post(PROBLEM, params=asked | {"material": "clay"}, content=content()).json()["issues"][0]["message"]
    assert refused.startswith("“Soil law”: ")


def test_several_specimens_make_a_combined_problem(app: App) -> None:
    answer = made(app, "BH1/3/1/4.60", "BH1/3/2/4.70")
    problem = answer["problem"]
    assert answer["specimens"] == ["BH1/3/1/4.60", "BH1/3/2/4.70"]
    assert [part["kind"] for part in problem["forward_model"]["parts"].values()] == ["oedometer", *["triaxial"] * 3]
    assert len(problem["observations"]) == 4
    assert any(f"c' {COHESION:g} kPa, phi' {PHI:g} degree" in note for note in answer["notes"])
    draft = app.post(f"{API}/problems/read", json=problem).json()
    assert (draft["valid"], draft["issues"]) == (True, [])
    assert made(app, "BH1")["problem"] == problem  # a borehole, as on the command line


def test_readings_of_instruments_come_as_files_that_can_be_read(app: App) -> None:
    answer = made(app, "BH3/P1")
    assert (answer["problem"], answer["specimens"]) == (None, [])
    assert [one["name"] for one in answer["readings"]] == ["BH3_P1_PRES.csv", "BH3_P1_LEV.csv"]
    assert any("the first 'DRY' in line" in note for note in answer["notes"])
    found = app.post(f"{API}/measurements?name=a.csv", content=answer["readings"][0]["csv"].encode()).json()
    assert [(column["label"], column["unit"]) for column in found["columns"][:2]] == [("time", "day"), ("PRES", "kPa")]
    assert found["columns"][1]["values"] == [12.0, 14.5, 20.25]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (b"", "a.ags contains no groups; give a file in the AGS 4 format"),
        (b"time,u\n1,2\n", "a.ags line 1 begins with 'time'; GROUP, HEADING, UNIT, TYPE, DATA are accepted"),
        (b"\x89PNG\r\n\0\0", "a.ags is not a text file"),
        (b'"**PROJ"\r\n"*PROJ_ID"\r\n', "is AGS 3; AGS 4 is accepted. Ask for the data as AGS 4"),
        (b'"GROUP","CONG"\r\n"HEADING","A"\r\n"DATA","1","2"\r\n', "a.ags line 3: group CONG: 2 cells of DATA under 1"),
        (b'"GROUP","CONG"\r\n"HEADING","A"\r\n"DATA","1\r\n', "a.ags line 3: unexpected end of data; cells in double"),
        (groups()["CONS"].encode(), "group CONS needs the group CONG, which is missing"),
        (b'"' + b"x" * 100_001, "a.ags line 1 has 100002 characters; at most 100000 are accepted"),
    ],
)
@pytest.mark.parametrize("path", [LIST, PROBLEM])
def test_a_broken_file_is_explained(app: App, path: str, text: bytes, message: str) -> None:
    answer = app.post(path, params={"name": "a.ags"}, content=text)
    assert answer.status_code == 422
    assert answer.json()["type"].endswith("unreadable-file")
    assert message in answer.json()["detail"]


@pytest.mark.parametrize(
    ("query", "message"),
    [
        ({}, "holds 5 tests, which need not be of one soil; choose with specimen ID: BH1/3/1/4.60"),
        ({"specimen": "BH9"}, "'BH9' is not an ID in this file"),
        ({"specimen": "BH1/3/1/4.6"}, "did you mean"),
        ({"specimen": "BH2/7/3"}, "no problem can be made of these tests; BH2/7/3/9.10: UU, total stresses"),
        ({"specimen": "BH2/7/1"}, "CONG_TYPE is SWELL, which is not a compression"),
        ({"specimen": "BH1/3/1", "material": "x"}, "material: unknown law 'x'"),
        ({"specimen": "BH1/3/1", "initial_stress": "12"}, "initial_stress must be above 0 and below 12 kPa"),
        ({"specimen": "BH1/3/1", "initial_stress": "0"}, "initial_stress"),
        ({"specimen": "BH1/3/1", "stage_duration": "nan"}, "stage_duration"),
        ({"specimen": "BH1/3/1", "stage_duration": "long"}, "stage_duration"),
        ({"specimen": ["BH1"] * 201}, "specimen"),
    ],
)
def test_a_choice_that_makes_nothing_is_explained(app: App, query: dict[str, Any], message: str) -> None:
    answer = app.post(PROBLEM, params={"name": "synthetic.ags", **query}, content=content())
    assert answer.status_code == 422
    assert message in answer.text


def test_limits_and_the_process_are_those_of_other_files(app: App) -> None:
    for path in (LIST, PROBLEM):
        assert app.post(path, content=b"x" * (32 * 2**20 + 1)).status_code == 413
        assert is_compute({"type": "http", "method": "POST", "path": path})


def test_of_a_long_file_the_first_tests_are_listed(app: App) -> None:
    keys = '"LOCA_ID","MONG_ID","MOND_DTIM","MOND_TYPE","MOND_RDNG"'
    rows = "".join(f'"DATA","BH{n}","P","2026-03-01","PRES","1"\r\n' for n in range(2001))
    answer = app.post(LIST, content=f'"GROUP","MOND"\r\n"HEADING",{keys}\r\n{rows}'.encode()).json()
    assert (answer["count"], len(answer["items"])) == (2001, 2000)


def test_both_clients_import(server: LiveServer, tmp_path: Path) -> None:
    file = tmp_path / "synthetic.ags"
    file.write_bytes(content())
    with Client(server.url) as client:
        assert client.read_ags(file)[0]["id"] == "BH1/3/1/4.60"
        found = client.import_ags(file, ["BH1/3/1"], stage_duration=0.5)
        assert found["problem"]["forward_model"]["stages"][0]["duration"] == 0.5
        with pytest.raises(HttpError, match="choose with specimen"):
            client.import_ags(file)

    async def asked() -> dict[str, Any]:
        async with AsyncClient(server.url) as client:
            assert await client.read_ags(file)
            return await client.import_ags(file, ["BH1/3/1"], stage_duration=0.5)

    assert asyncio.run(asked()) == found
