"""Every dependency has its bounds, and its reason in the decision record."""

from __future__ import annotations

import re

from tests.contracts.repository import ROOT, project

RECORD = ROOT / "docs" / "decisions" / "0003-dependencies.md"
REQUIREMENT = re.compile(r"(?P<name>[A-Za-z0-9._-]+)(\[[\w,]+\])?(?P<bounds>.+)")
HEADINGS = {
    "dependencies": "Base",
    "server": "Extra `server`",
    "tracing": "Extra `tracing`",
    "plots": "Extra `plots`",
    "mesh": "Extra `mesh`",
    "statistics": "Extra `statistics`",
    "parquet": "Extra `parquet`",
    "pest": "Extra `pest`",
    "mfront": "Extra `mfront`",
    "bench": "Extra `bench`",
    "dev": "Extra `dev`",
}


def requirements() -> dict[str, list[re.Match[str]]]:
    section = project()["project"]
    groups = {"dependencies": section["dependencies"], **section["optional-dependencies"]}
    found = {}
    for group, lines in groups.items():
        matches = [REQUIREMENT.fullmatch(line) for line in lines]
        assert None not in matches, (group, lines)
        found[group] = [match for match in matches if match is not None]
    return found


def test_every_dependency_has_a_lower_and_an_upper_bound() -> None:
    for group, found in requirements().items():
        for match in found:
            assert re.fullmatch(r">=[\d.]+,<[\d.]+", match["bounds"]), (group, match.string)


def test_the_record_gives_each_dependency_a_reason_and_a_licence() -> None:
    parts = re.split(r"^### ", RECORD.read_text(encoding="utf-8"), flags=re.MULTILINE)
    for group, found in requirements().items():
        (part,) = (part for part in parts if part.startswith(HEADINGS[group]))
        rows = re.findall(r"^\| ([\w.-]+) \| (.+?) \| (.+?) \|$", part, flags=re.MULTILINE)
        recorded = {name for name, _, _ in rows} - {"package"}
        assert recorded == {match["name"] for match in found}, group
