"""The sections of a table of tests: a row, and a table with what all its rows share."""

from __future__ import annotations

from typing import Any, Literal, TypeAlias

from pydantic import ConfigDict, Field

from geoswarm.solver.forward.staged_section import MAX_DURATION, MAX_STRESS
from geoswarm.solver.section import Section

__all__ = ["SpecimenRow", "SpecimenTable", "TestKind"]

TestKind: TypeAlias = Literal["oedometer", "isotropic_compression", "triaxial"]


class SpecimenRow(Section):
    """A laboratory test. Further keys are those of its part, and the columns of its series."""

    model_config = ConfigDict(extra="allow")

    name: str | None = Field(
        None, min_length=1, max_length=100, description="name of the test; that of its file or sheet if absent"
    )
    kind: TestKind | None = Field(
        None, description="the test; a table may also say isotropic, triaxial drained, triaxial undrained, CD, CU"
    )
    file: str | None = Field(
        None, min_length=1, description="CSV file or workbook (XLSX, ODS) with its readings, relative to this file"
    )
    sheet: str | None = Field(None, min_length=1, description="sheet of a workbook")
    cell_pressure: float | None = Field(
        None, gt=0, le=MAX_STRESS, description="effective stress at the beginning of shearing, kPa (triaxial)"
    )
    initial_stress: float | None = Field(
        None,
        gt=0,
        le=MAX_STRESS,
        description="stress under which initial_void_ratio holds, kPa; if absent cell_pressure (triaxial), or the "
        "first stress of the readings",
    )
    initial_void_ratio: float | None = Field(
        None,
        gt=0,
        le=100,
        description="void ratio at the beginning; if absent the first of the readings, if they have it",
    )
    drainage: Literal["drained", "undrained"] | None = Field(None, description="drainage of shearing (triaxial)")
    rate: float | None = Field(
        None, gt=0, description="rate of axial strain, 1/day, for laws on which time has an effect (triaxial)"
    )
    stage_duration: float | None = Field(
        None,
        gt=0,
        le=MAX_DURATION,
        description="duration of each load, day, for laws on which time has an effect (not triaxial)",
    )
    x: str | None = Field(
        None, min_length=1, description="column of the axial strain (triaxial) or stress; by the headings if absent"
    )
    x_unit: str | None = Field(None, description="unit of x, where the heading of its column does not name it")


class SpecimenTable(SpecimenRow):
    """A table of laboratory tests; other keys hold for every row that does not give them."""

    table: str | None = Field(
        None, min_length=1, description="CSV file or workbook (XLSX, ODS) with a row a test, relative to this file"
    )
    table_sheet: str | None = Field(None, min_length=1, description="sheet of the table, where it is a workbook")
    rows: list[dict[str, Any]] | None = Field(
        None, min_length=1, max_length=100, description="the tests themselves; give these or table"
    )
