"""The section of one observation: its readings or their file, and how they are processed."""

from __future__ import annotations

from typing import Annotated, Literal, TypeAlias

from pydantic import AfterValidator, Field, field_validator, model_validator
from pydantic_core import PydanticCustomError

from geoswarm.solver.problem.readings.joined import BlockSection
from geoswarm.solver.problem.readings.preparation import Resample
from geoswarm.solver.problem.readings.zero import ZeroReading
from geoswarm.solver.problem.tables.dates import DateForm, moment_in
from geoswarm.solver.problem.tables.headings import known_unit
from geoswarm.solver.problem.tables.numerals import DecimalSign
from geoswarm.solver.residuals import Distance, LossKind
from geoswarm.solver.section import Section
from geoswarm.solver.sentences import SentenceError, setting
from geoswarm.solver.units import UnitError, base_unit

__all__ = ["ObservationSection", "PointsSection"]


class PointsSection(Section):
    """Measured points inside the problem file."""

    x: list[float] = Field(min_length=1, description="x of the points, in x_unit")
    y: list[float] = Field(min_length=1, description="measured y, in y_unit")
    weight: list[Annotated[float, Field(ge=0)]] | None = Field(
        None, description="weights w_h of the points; if absent 1, or by readings, with a mean of 1"
    )
    readings: list[Annotated[float, Field(ge=1)]] | None = Field(
        None, description="number of readings of which each point is the mean; 1 each if absent"
    )
    independent: float | None = Field(
        None,
        ge=1,
        description="number of independent readings that all points are worth; if absent, error is that of a point",
    )
    range: float | None = Field(
        None, ge=0, description="max - min of the readings of which the points are means; that of the points if absent"
    )
    inputs: dict[str, list[float]] | None = Field(
        None, description="further quantities at the points that a formula uses by name, one value for each x"
    )


def _moment(text: str) -> str:
    if moment_in(text) is None:
        raise PydanticCustomError("moment", "must be a date with or without time, such as 2024-03-01 08:30")
    return text


def _printable(text: str) -> str:
    if not text.isprintable():
        raise PydanticCustomError("note", "must be printable text on one line, without control characters")
    return text


Note: TypeAlias = Annotated[str, Field(min_length=1, max_length=500), AfterValidator(_printable)]

Moment: TypeAlias = Annotated[str, AfterValidator(_moment)]

Name: TypeAlias = Annotated[str, Field(min_length=1, max_length=500)]

_OF_A_FILE = (
    "sheet",
    "x_column",
    "y_column",
    "y_minus",
    "weight_column",
    "gross_error_column",
    "inputs",
    "where",
    "x_dates",
    "x_time_column",
    "x_origin",
    "blocks",
    "decimal_sign",
    "incomplete_rows",
    "no_reading",
)


class ObservationSection(Section):
    """Measured points of one series."""

    series: str = Field(description="name of a series of the forward model")
    points: PointsSection | None = Field(None, description="the points themselves; give these or file")
    file: str | None = Field(
        None,
        min_length=1,
        description="CSV file or workbook (XLSX, ODS) with columns x, y[, weight], relative to this file",
    )
    sheet: str | None = Field(
        None,
        min_length=1,
        description="sheet of a workbook; if absent the only one with these columns, else the first with cells",
    )
    x_column: str | None = Field(
        None,
        min_length=1,
        description="header of the file's x column, if it is not x; also its letter (B:B), its cells (B5:B30) or what "
        "the workbook calls these cells",
    )
    y_column: str | None = Field(
        None, min_length=1, description="header (or letter, cells, name) of the file's y column, if it is not y"
    )
    y_minus: str | None = Field(
        None, min_length=1, description="column subtracted from that of y, row by row: the second gauge"
    )
    weight_column: str | None = Field(
        None, min_length=1, description="header of the weight column, if it is not weight"
    )
    inputs: dict[str, str] | None = Field(
        None, description="columns of further quantities that a formula uses, header by name: {T: temperature}"
    )
    where: dict[Name, str | float] | None = Field(
        None,
        min_length=1,
        max_length=10,
        description="only rows with these entries, by header: {specimen: S1}; an empty cell means the entry above it",
    )
    gross_error_column: str | None = Field(
        None,
        min_length=1,
        description="column with an entry for every reading that is a gross error (empty, 0, no, ok, -: none)",
    )
    x_dates: DateForm | None = Field(
        None,
        description="how dates of x are written where it is not plain: day_first (31/12/2024), month_first "
        "(12/31/2024), year_first (24/12/31), serial (numbers of days, as spreadsheets count), or how the time since "
        "the start is: hh:mm:ss, hh:mm, mm:ss",
    )
    x_time_column: str | None = Field(
        None, min_length=1, description="column with the time of day, where x holds dates only"
    )
    x_origin: Moment | None = Field(
        None, description='where x holds dates: the one at which x is 0 ("2024-03-01 08:30"); the first if absent'
    )
    blocks: list[BlockSection] | None = Field(
        None,
        min_length=1,
        max_length=50,
        description="parts of the file that are joined in this order, stages side by side or on sheets of their own: "
        "[{x_column: A:A, y_column: B:B, stage: 1}, {x_column: D:D, y_column: E:E, stage: 2}]",
    )
    decimal_sign: DecimalSign | None = Field(
        None,
        description="how the file writes numbers where 1,000 may be 1 or 1000: comma (1,5 and 1.000) or point (1.5 and "
        "1,000)",
    )
    incomplete_rows: Literal["leave_out"] | None = Field(
        None, description="leave out rows that lack one of the required numbers; otherwise they are errors"
    )
    no_reading: list[float] | None = Field(
        None,
        max_length=10,
        description="numbers that the file has for missing readings, [-999]: rows with them are left out; [] where "
        "such numbers are readings; asked for if absent",
    )
    x_unit: str | None = Field(
        None,
        description="unit of x in the data; if absent, that of its heading in the file "
        "(required there, except for numbers without dimension), or the base unit of the series for points",
    )
    y_unit: str | None = Field(
        None,
        description="unit of y in the data; if absent, that of its heading in the file "
        "(required there, except for numbers without dimension), or the base unit of the series for points",
    )
    x_factor: float = Field(1.0, description="factor for x, before all else: -1 changes the sign")
    y_zero: Literal["first"] | ZeroReading | None = Field(
        None,
        description="the zero reading, which is subtracted: first, {x: 0.5} for the reading at that x, or {y: 12.31}",
    )
    y_factor: float = Field(
        1.0,
        description="factor for y, after the zero reading is subtracted: -1 changes the sign; the constant of a gauge",
    )
    gross_errors: list[Annotated[int, Field(ge=1)]] = Field(
        default=[],
        max_length=10_000,
        description="numbers of the readings, from 1, that are gross errors: they are shown but not used",
    )
    sort: bool = Field(False, description="put the readings in the order of x first")
    repeated_x: Literal["average", "shift"] | None = Field(
        None,
        description="readings at equal x: average takes their mean, shift spreads them evenly up to the next x",
    )
    resample: Resample | None = Field(
        None, description="replaces very many readings with means of neighbouring ones: {per_decade: 20} or {every: 10}"
    )
    weight: float = Field(1.0, ge=0, description="weight w_g of the series in the objective")
    error: float | None = Field(None, gt=0, description="standard deviation of a reading, in y_unit, where it is known")
    distance: Distance | None = Field(
        None,
        description="how residuals are measured: vertical (y calculated less measured; if absent) or orthogonal "
        "(distance of a reading from the calculated curve, x and y in parts of their ranges; for peaks that may shift)",
    )
    loss: LossKind | None = Field(
        None,
        description="weighs readings far from the curve less than by their square, so that outliers do not dominate "
        "the fit: soft_l1, huber or cauchy; squares if absent",
    )
    loss_scale: float | None = Field(
        None,
        gt=0,
        allow_inf_nan=False,
        description="residual, in y_unit, above which the loss weighs less; if absent 1.287 (soft_l1), 1.345 (huber) "
        "or 2.385 (cauchy) times error",
    )
    x_from: float | None = Field(None, description="points with a smaller x, in x_unit, are left out")
    x_to: float | None = Field(None, description="points with a larger x, in x_unit, are left out")
    stage_x_from: float | None = Field(
        None,
        ge=0,
        description="of a test in stages: readings sooner after their load than this, in x_unit, are left out (those "
        "before the end of primary consolidation, which the soil laws do not contain)",
    )
    leave_out_stages: list[Annotated[int, Field(ge=1)]] = Field(
        default=[], max_length=1000, description="numbers of stages, from 1, whose readings are left out"
    )

    notes: list[Note] = Field(
        default=[],
        max_length=20,
        description="where the readings come from and what was done to them, for the report; geoswarm adds its own",
    )

    @field_validator("x_unit", "y_unit")
    @classmethod
    def _units_of_laboratories(cls, unit: str | None) -> str | None:
        """Spell ``kg/cm2`` as the registry of units does; what it knows itself stays as it is."""
        if unit is None:
            return None
        try:
            base_unit(unit)
        except UnitError:
            return known_unit(unit)[0] or unit
        return unit

    @field_validator("x_factor", "y_factor")
    @classmethod
    def _factor(cls, value: float) -> float:
        if value == 0.0:
            raise PydanticCustomError("factor", "must not be 0")
        return value

    @model_validator(mode="after")
    def _one_source(self) -> ObservationSection:
        if (self.points is None) == (self.file is None):
            given = "both are given" if self.file else "none is given"
            raise PydanticCustomError("one_source", "give either points or file; {given}", {"given": given})
        staged = [block.stage is not None for block in self.blocks or ()]
        if any(staged) and not all(staged):
            raise PydanticCustomError("blocks", "some blocks have a stage and others none; give it to all of them")
        if any(staged) and (self.x_origin is not None or self.x_factor != 1.0):
            keys = setting("x_origin"), ", ", setting("x_factor")
            raise SentenceError("x of blocks with stage is time since its load: leave out ", *keys)
        if self.loss is None and self.loss_scale is not None:
            loss = " is that of a loss: give ", setting("loss"), " as well (soft_l1, huber, cauchy)"
            raise SentenceError(setting("loss_scale"), *loss)
        if self.loss is not None and self.loss_scale is None and self.error is None:
            scale = " needs a scale; give ", setting("loss_scale"), ", or the ", setting("error"), " of a reading"
            raise SentenceError(setting("loss", self.loss), *scale)
        columns = [name for name in _OF_A_FILE if getattr(self, name) is not None]
        if self.file is None and columns:
            raise PydanticCustomError(
                "columns", "{columns} can only be given with file", {"columns": ", ".join(columns)}
            )
        return self
