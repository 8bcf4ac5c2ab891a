"""Models of what is answered about problems in the making: drafts, files of measurements, examples."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import Base64Bytes, BaseModel, Field

from geoswarm.api.errors import KeyWords
from geoswarm.api.schemas.responses import Model, Number
from geoswarm.records.problem import Parameter, Series

__all__ = [
    "DraftEstimate",
    "DraftIssue",
    "DraftObservation",
    "DraftSketch",
    "Example",
    "ExampleList",
    "ExampleSummary",
    "FilesOfTests",
    "MeasuredPoints",
    "MeasuredStages",
    "MeasurementColumn",
    "MeasurementFile",
    "ProblemDraft",
    "ProblemOfTests",
]


class DraftIssue(Model):
    """One mistake in a draft."""

    path: str = Field(description="where it is, for example parameters.c.lower; empty for the whole")
    message: str
    line: int | None = Field(description="in yaml, counted from 1")
    parts: list[str | KeyWords] = Field(description="the message with the keys in it; empty where it names none")


class DraftObservation(BaseModel):
    """What becomes of the measured points of a series; ``x_factor`` and ``y_factor`` lead to base units."""

    series: str
    points: int
    weight: float = Field(description="w_g in the objective, with the weighting scheme")
    share: float = Field(description="of the objective, if every series is missed by the same part of its range")
    x_unit: str
    y_unit: str
    x_factor: Number
    y_factor: Number


class DraftSketch(BaseModel):
    """A drawing of the forward model: a specimen or the ground, or its loading programme."""

    part: str = Field(description="of a combined model; empty otherwise")
    heading: str
    words: str = Field(description="what is drawn, in words")
    svg: str = Field(description="an svg element whose classes the page gives their colours")


class DraftEstimate(Model):
    """What a parameter may be, by its readings or by index properties of the soil."""

    parameter: str
    unit: str
    lower: float = Field(description="value less the published scatter; the value where none is published")
    value: float
    upper: float
    source: str = Field(description="method of the evaluation, or equation and source of the correlation")
    measured: bool = Field(description="whether it was read of the test's curve")


class ProblemDraft(BaseModel):
    """A problem that may still have mistakes, with the forward model's parameters and series so far."""

    valid: bool = Field(description="whether it could be submitted as it is")
    document: dict[str, Any] | None = Field(description="the problem as given; null when the text cannot be read")
    yaml: str | None = Field(description="the problem as YAML; null when it is too long to be edited as text")
    issues: list[DraftIssue]
    warnings: list[str] = Field(description="as a check gives them: what is possible, but seldom meant")
    warning_parts: list[list[str | KeyWords]] = Field(description="the same with the keys in them")
    parameters: list[Parameter] | None = Field(description="of the forward model; null while its section has mistakes")
    series: list[Series] | None
    open_parameters: bool = Field(description="the problem may name parameters of its own (a formula)")
    sketches: list[DraftSketch] | None = Field(
        description="of laboratory tests, layered ground and sections, at most 12 parts; null while there are mistakes"
    )
    observations: list[DraftObservation] = Field(description="empty while there are mistakes")
    estimates: list[DraftEstimate] = Field(description="of readings only without mistakes; of index properties before")
    to_be_accepted: list[str] = Field(description="series that `accept` must name for the problem to run as it is")
    free_parameters: list[str]
    planned_evaluations: int | None = Field(description="null with mistakes, or when no number limits the search")


class FilesOfTests(BaseModel):
    """A problem with a table of laboratory tests, and its files."""

    problem: dict[str, Any] = Field(description="with `tests`; other missing parts are not errors")
    files: dict[str, Base64Bytes] = Field(
        max_length=200, description="contents in base64 by name, without folders: the table and the files of its rows"
    )


class ProblemOfTests(BaseModel):
    """A problem with parts and observations instead of its table of tests."""

    problem: dict[str, Any]


class MeasurementColumn(Model):
    """A column of a file."""

    name: str = Field(description="heading as it stands")
    letters: str = Field(description="of the column, as spreadsheets call it")
    label: str = Field(description="heading without its unit")
    unit: str | None = Field(description="unit that the heading or a comment names")
    base: str | None = Field(description="base unit of its dimension: day, m, kPa, degree or dimensionless")
    unclear: str | None = Field(description="why the heading leaves the unit open though it names some")
    quantities: list[str] = Field(description="what its words may stand for: settlement, time, specimen ...")
    kind: Literal["number", "time", "clock", "text"] = Field(description="time: dates, given as days since the first")
    values: list[float | None] = Field(
        description="one a row; null where there is no number, or one that can be read in two ways; empty for text"
    )
    bad: int = Field(description="cells that hold something else")
    doubt: str | None = Field(
        description="a cell that can be read in two ways: 1,000 (decimal_sign says how), 03/04/2024 (x_dates)"
    )
    entries: dict[str, int] = Field(description="number of rows of each entry, where these are at most 50")
    first: list[str] = Field(description="its first cells as they stand")


class MeasurementFile(Model):
    """What a file of measurements holds."""

    name: str
    sheets: list[str] = Field(description="of a workbook; empty for CSV")
    sheet: str | None = Field(description="the one that was read")
    rows: int
    columns: list[MeasurementColumn]
    formulas: list[str] = Field(description="cells of the sheet whose formula has no stored value")
    alike: list[str] = Field(description="sheets with the headings of this one, where there are several")


class MeasuredPoints(Model):
    """Readings of one series from a file, as a problem has them."""

    x: list[float]
    y: list[float]
    x_unit: str = Field(description="the one that the observation gives, or that the file names; else `unstated`")
    y_unit: str
    weight: list[float] | None
    readings: list[float] | None = Field(description="number of readings of which each point is the mean")
    independent: float | None = Field(description="number of independent readings that the points are worth")
    range: float | None = Field(description="max - min of the readings of which the points are means")
    inputs: dict[str, list[float]] = Field(description="further quantities at the points")
    gross_errors: list[int] = Field(description="numbers of those marked as gross errors, from 1")
    notes: list[str] = Field(description="what was read and done")


class MeasuredStage(Model):
    """A load of a test in stages."""

    stress: float = Field(description="kPa")
    duration: float = Field(description="day")
    load: float = Field(description="as the file has it")


class MeasuredStages(Model):
    """Stages of a test from a column of loads."""

    stages: list[MeasuredStage]
    initial_stress: float | None = Field(description="kPa; the load that the first reading alone has")
    elapsed: bool = Field(description="x restarts in every stage: the readings need `blocks` with their stage")


class ExampleSummary(BaseModel):
    """An example that comes with the program."""

    name: str
    title: str = Field(description="name of its problem")
    forward_model: str
    description: str = Field(description="what the first comment of its file says")


class ExampleList(BaseModel):
    """Examples in alphabetical order."""

    items: list[ExampleSummary]


class Example(ExampleSummary):
    """An example with its problem, which can be submitted as it is."""

    problem: dict[str, Any]
