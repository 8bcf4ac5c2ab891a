"""Tables of predictions, and of the worth of further tests."""

from __future__ import annotations

from collections.abc import Mapping

from geoswarm.solver.identifiability.prediction.bands import Prediction
from geoswarm.solver.identifiability.worth.outcome import Design
from geoswarm.solver.report.document.parts import Table
from geoswarm.solver.report.figures.labels import ParameterLabel
from geoswarm.solver.report.figures.outlook.design_plot import CRITERIA
from geoswarm.solver.words import number, per_cent

__all__ = ["design_table", "prediction_table"]

_SHOWN = 8  # points of a series
_MOST_SERIES = 12
"""Series whose bands are shown; of more measured ones it is shown how close they come."""


def prediction_table(prediction: Prediction) -> Table:
    """Return the band at some points of every series, the last one among them."""
    if len(prediction.series) > _MOST_SERIES and any(one.closeness is not None for one in prediction.series):
        return _closeness_table(prediction)
    rows = []
    reading = any(one.reading_lower is not None for one in prediction.series)
    for one in prediction.series:
        count = one.x.size
        step = max(1, -(-count // _SHOWN))
        chosen = sorted({*range(count - 1, -1, -step)})
        for i in chosen:
            x = f"{number(float(one.x[i]), 4)} {one.x_unit}".rstrip()
            band = f"{number(float(one.lower[i]), 4)} … {number(float(one.upper[i]), 4)}"
            cells = [one.series, x, number(float(one.median[i]), 4), band]
            if reading:
                known = one.reading_lower is not None and one.reading_upper is not None
                cells.append(
                    f"{number(float(one.reading_lower[i]), 4)} … {number(float(one.reading_upper[i]), 4)}"  # type: ignore[index]
                    if known
                    else "–"
                )
            rows.append((*cells, one.y_unit or "–"))
    level = per_cent(prediction.level)
    columns = ("series", "x", "median", f"{level} band", *((f"{level} of readings",) if reading else ()), "unit")
    said = " ".join(((prediction.alarm,) if prediction.alarm else ()) + prediction.remarks)
    inside = [
        f"{one.inside} of {one.x.size} measured points of {one.series} lie in the band"
        f"{' of readings' if one.reading_lower is not None else ''}."
        for one in prediction.series
        if one.inside is not None
    ]
    note = " ".join([said, *inside, f"{prediction.runs} runs."])
    return Table(f"Prediction: {prediction.name}", columns, tuple(rows), (1, 2), note)


def _closeness_table(prediction: Prediction) -> Table:
    """Return a line for each measured series: how close it comes."""
    rows = []
    for one in prediction.series:
        if (found := one.closeness) is not None:
            amounts = [f"{number(value, 3)} {found.unit}".rstrip() for value in (found.deviation, found.largest)]
            peak = "–" if found.peak is None else per_cent(found.peak)
            rows.append((one.series, *amounts, peak, f"{one.inside} of {one.x.size}"))
    columns = ("series", "root mean square", "largest", "peak within", "points in the band")
    said = " ".join(((prediction.alarm,) if prediction.alarm else ()) + prediction.remarks)
    note = f"{said} {prediction.runs} runs for the {per_cent(prediction.level)} band."
    return Table(f"Prediction: {prediction.name}", columns, tuple(rows), (1, 2, 3, 4), note)


def design_table(design: Design, labels: Mapping[str, ParameterLabel]) -> Table:
    """Return the candidates in order of their worth, with the expected reduction of each interval."""
    names = list(design.best.parameters)
    several, costs = design.basins > 1, design.best.cost is not None
    columns = ["candidate", "readings", *(labels[n].symbol if n in labels else n for n in names), "all", "region"]
    columns += [design.predicted] if design.predicted is not None else []
    columns += ["distinguishes basins"] if several else []
    columns += ["cost", "per cost"] if costs else []
    rows = []
    for c in design.candidates:
        cells = [c.name, str(c.readings), *(_part(c.parameters[n]) for n in names), _part(c.widths), _part(c.volume)]
        cells += [_part(c.prediction)] if design.predicted is not None else []
        cells += [_part(c.distinguishes)] if several else []
        cells += [number(c.cost), number(c.per_cost, 3)] if costs else []
        rows.append(tuple(cells))
    said = " ".join(((design.alarm,) if design.alarm else ()) + design.remarks)
    note = (
        f"Expected reduction of the width of each 95 % interval, of all (geometric mean) and of the common region (its "
        f"root); the order is that of: {CRITERIA[design.criterion]}. Averaged over {design.centres} sets of "
        f"parameters. {said}"
    )
    return Table("Which test next", tuple(columns), tuple(rows), tuple(range(1, len(columns))), note)


def _part(value: float | None) -> str:
    return "–" if value is None else per_cent(value)
