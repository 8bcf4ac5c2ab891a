"""Contents of a report, in order: verdicts, pictures, tables, provenance. HTML and PDF differ only in form."""

from __future__ import annotations

import json
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from geoswarm.solver.identifiability import Statistics
from geoswarm.solver.identifiability.misfits import headline_of
from geoswarm.solver.identifiability.residuals.lack_of_fit import FitVerdict
from geoswarm.solver.identifiability.stored.follow_ups import follow_up_of
from geoswarm.solver.identifiability.stored.verdict_words import where_intervals_hold
from geoswarm.solver.problem import FreeParameter, LinkedParameter, Problem
from geoswarm.solver.report.compared import Compared
from geoswarm.solver.report.curves import objective_unit
from geoswarm.solver.report.document.captions import CAPTIONS
from geoswarm.solver.report.document.laboratory import laboratory_tables
from geoswarm.solver.report.document.parts import Alarm, Card, Picture, Table
from geoswarm.solver.report.document.readings import gross_error_table, not_modelled, reading_notes, residual_table
from geoswarm.solver.report.document.series_table import comparison_table, series_table
from geoswarm.solver.report.document.uncertainty_tables import left_out_table, uncertainty_tables
from geoswarm.solver.report.figures.figure_set import FigureSet
from geoswarm.solver.report.figures.labels import ParameterLabel, parameter_labels
from geoswarm.solver.report.parts import PARTS, Part
from geoswarm.solver.report.record import BestFit, RunRecord, method_in_words
from geoswarm.solver.report.uncertainty import NOTHING_FURTHER, Uncertainty
from geoswarm.solver.words import duration, ends, number, reasons_in_words, typeset

__all__ = ["Content", "report_content"]


@dataclass(frozen=True, slots=True)
class Content:
    """Everything that a report says, as text; the figures are drawn from ``figures`` by the name of a picture."""

    title: str
    state: str
    facts: tuple[tuple[str, str], ...]
    summary: str
    alarm: Alarm | None
    cards: tuple[Card, ...]
    notes: tuple[str, ...]
    pictures: tuple[Picture, ...]
    tables: tuple[Table, ...]
    provenance: tuple[tuple[str, str], ...]
    problem: str
    figures: FigureSet

    def only(self, parts: Collection[Part]) -> Content:
        """Return some of the parts; title, facts, alarm and summary are in every report, which says what it shows."""
        wanted = {"classical": "classical" in parts}  # by picture; the others are figures
        return replace(
            self,
            facts=(*self.facts, ("this report shows", ", ".join(part for part in PARTS if part in parts))),
            cards=self.cards if "verdicts" in parts else (),
            notes=self.notes if "verdicts" in parts else (),
            pictures=tuple(one for one in self.pictures if wanted.get(one.name, "figures" in parts)),
            tables=tuple(one for one in self.tables if ("classical" if one.classical else "tables") in parts),
            provenance=self.provenance if "provenance" in parts else (),
        )

    @property
    def classical(self) -> tuple[Table, ...]:
        """Tables next to the constructions of the classical evaluation."""
        return tuple(table for table in self.tables if table.classical)

    @property
    def others(self) -> tuple[Table, ...]:
        """All other tables."""
        return tuple(table for table in self.tables if not table.classical)


def report_content(
    problem: Problem,
    record: RunRecord,
    statistics: Statistics | None,
    figures: FigureSet,
    uncertainty: Uncertainty = NOTHING_FURTHER,
    compared: Compared | None = None,
) -> Content:
    """Put together what a report says.

    Parameters
    ----------
    problem, record
        What was asked for and how it went.
    statistics
        The statistics; None when there are none, because no evaluation has succeeded for example.
    figures
        Those that can be drawn.
    uncertainty
        What follow-ups and a posterior sample have found.
    compared
        Another set of parameters beside the result.
    """
    labels = parameter_labels(problem)
    unit = objective_unit(problem)
    best = record.best
    facts = (
        ("best objective", _quantity(None if best is None else best.objective, unit)),
        ("evaluations", str(record.evaluations)),
        ("failed", str(record.failed)),
        ("generations", str(record.generations)),
        ("running time", duration(record.seconds)),
        ("stopped", reasons_in_words(record.stop_reasons)),
    )
    follow_up = follow_up_of(problem)
    judged = follow_up is None or uncertainty.findings.linearisation is not None
    cards = (
        tuple(_card(statistics, name, labels, record, uncertainty) for name in problem.free_names)
        if judged and statistics is not None
        else ()
    )
    return Content(
        title=problem.name,
        state=record.state,
        facts=facts,
        alarm=_alarm(None if statistics is None else statistics.fit, uncertainty),
        summary=_summary(cards, record) if judged else uncertainty.summary(record.evaluations),
        cards=cards,
        notes=tuple(
            map(
                typeset,
                (
                    *reading_notes(problem),
                    *(f"Assumed: {sentence}" for sentence in problem.forward_model.assumptions),
                    *(_notes(problem, statistics) if judged and statistics is not None else ()),
                    *uncertainty.notes,
                ),
            )
        ),
        pictures=tuple(_picture(figures, name) for name in figures.shown),
        tables=tuple(_tables(problem, record, statistics, labels, uncertainty, compared)),
        provenance=tuple(_provenance(problem, record).items()),
        problem=_listing(_short(problem.document())),
        figures=figures,
    )


def _picture(figures: FigureSet, name: str) -> Picture:
    heading, caption, wide = CAPTIONS.get(name.partition(".")[0], (name, "", False))
    wide = wide or (name == "fit" and figures.fit_is_wide)
    told = figures.told(name) or (heading, caption)
    return Picture(name, told[0], told[1] or caption, wide)


def _alarm(fit: FitVerdict | None, uncertainty: Uncertainty) -> Alarm | None:
    """What is wrong with the fit as a whole; None where nothing is."""
    for found in (uncertainty.findings.fit, fit):
        if found is not None and found.headline:
            remedies = tuple(typeset(remedy.text) for remedy in found.remedies)
            return Alarm(found.kind, found.headline, typeset(found.sentence), remedies)
    findings = uncertainty.findings
    alarms = [one.alarm for one in findings.predictions] + [one.alarm for one in findings.designs]
    for told in alarms:
        if told is not None:
            return Alarm("lack_of_fit", headline_of("lack_of_fit", ()), typeset(told), ())
    return None


def _card(
    statistics: Statistics,
    name: str,
    labels: dict[str, ParameterLabel],
    record: RunRecord,
    uncertainty: Uncertainty,
) -> Card:
    verdict = statistics.verdict(name)
    value = None if record.best is None else record.best.parameters[name]
    label = labels[name]
    remark = ""
    polished = _polished(uncertainty, record.best)
    if polished is not None:
        remark = f"polished; best evaluation {_quantity(value, label.unit)}"
        value = polished[name]
    proposals = tuple(typeset(one.text) for one in verdict.remedies)
    proposals += tuple(typeset(proposal.sentence) for proposal in verdict.proposals)
    return Card(
        name,
        label.symbol,
        _quantity(value, label.unit),
        remark,
        verdict.kind,
        verdict.words,
        typeset(verdict.sentence),
        proposals,
    )


def _polished(uncertainty: Uncertainty, best: BestFit | None) -> dict[str, float] | None:
    """Free parameters at the minimum that a follow-up found; None without one, or where it is the best evaluation."""
    findings = uncertainty.findings
    known = (findings.start_objective, None if best is None else best.objective)
    if findings.linearisation is None or findings.objective is None or findings.objective in known:
        return None
    return dict(zip(findings.linearisation.names, findings.linearisation.optimum.tolist(), strict=True))


def _summary(cards: Sequence[Card], record: RunRecord) -> str:
    if record.best is None:
        return record.error or "No evaluation has succeeded yet: there is nothing to judge."
    if not cards:
        return "There are too few evaluations for a judgement of the parameters."
    kinds = dict.fromkeys(card.words for card in cards)
    parts = [f"{words}: {', '.join(c.symbol for c in cards if c.words == words)}" for words in kinds]
    text = "; ".join(parts) + "."
    return text[:1].upper() + text[1:]


def _tables(
    problem: Problem,
    record: RunRecord,
    statistics: Statistics | None,
    labels: dict[str, ParameterLabel],
    uncertainty: Uncertainty,
    compared: Compared | None,
) -> list[Table]:
    tables = []
    best = record.best
    if best is not None:
        tables.append(_parameter_table(problem, best, statistics, labels, uncertainty))
        tables += _laboratory_tables(problem, best, statistics, _polished(uncertainty, best))
        tables.append(series_table(problem, best))
        if compared is not None:
            tables.append(comparison_table(problem, best, compared))
    if statistics is not None and len(statistics.pearson.names) > 1 and follow_up_of(problem) is None:
        tables.append(_correlation_table(statistics, labels))
    if statistics is not None:
        tables += _optimum_tables(statistics, labels)
    tables += uncertainty_tables(problem, uncertainty, labels)
    if (gross := gross_error_table(problem)) is not None:
        tables.append(gross)
    if record.failures:
        rows_of_failures = tuple((reason.replace("_", " "), str(count)) for reason, count in record.failures.items())
        tables.append(Table("Failed evaluations", ("reason", "number"), rows_of_failures, (1,)))
    return tables


def _parameter_table(
    problem: Problem,
    best: BestFit,
    statistics: Statistics | None,
    labels: dict[str, ParameterLabel],
    uncertainty: Uncertainty,
) -> Table:
    rows = []
    doubt = _doubt(statistics)
    values, free = best.parameters, _polished(uncertainty, best)
    polished = None if free is None else problem.values([free[name] for name in problem.free_names])
    for name, parameter in problem.parameters.items():
        label = labels[name]
        shown = name if label.symbol == name else f"{label.symbol} ({name})"
        cells = [shown, number(values[name]), *([] if polished is None else [number(polished[name])]), label.unit]
        if isinstance(parameter, FreeParameter):
            sure = _interval(statistics, name, doubt)
            cells += [f"{number(parameter.lower)} … {number(parameter.upper)}", parameter.scale, sure]
        elif isinstance(parameter, LinkedParameter):
            cells += [f"= {parameter.expression.text}", "linked", ""]
        else:
            cells += ["", "fixed", ""]
        rows.append(tuple(cells))
    more = () if polished is None else ("polished",)
    columns = ("parameter", "best value", *more, "unit", "search range", "scale", "95 % interval")
    note = "A dash: no interval can be given, because the data do not determine the parameter or it was not requested."
    if statistics is not None and statistics.linearisation is not None:
        note += f" {typeset(where_intervals_hold(statistics.basins.hidden))}"
    if polished is not None:
        findings, unit = uncertainty.findings, objective_unit(problem)
        note += (
            f" Polished by least squares, objective {_quantity(findings.start_objective, unit)} of the best evaluation "
            f"to {_quantity(findings.objective, unit)}, in a follow-up; intervals belong there."
        )
    return Table("Parameters", columns, tuple(rows), (1,) if polished is None else (1, 2), note)


def _doubt(statistics: Statistics | None) -> str:
    """What follows every interval where none holds."""
    fit = None if statistics is None else statistics.fit
    return f" ({fit.caution})" if fit is not None and fit.caution else ""


def _laboratory_tables(
    problem: Problem, best: BestFit, statistics: Statistics | None, polished: Mapping[str, float] | None
) -> list[Table]:
    """The parameters of laboratory tests as laboratories know them: polished where somebody went there."""
    responses = best.responses if polished is None else None
    values = best.parameters if polished is None else problem.values([polished[name] for name in problem.free_names])
    return laboratory_tables(
        problem, values, None if statistics is None else statistics.linearisation, responses, _doubt(statistics)
    )


def _correlation_table(statistics: Statistics, labels: dict[str, ParameterLabel]) -> Table:
    rows = []
    for pair in statistics.pearson:
        rank = statistics.spearman.get(pair.first, pair.second).coefficient
        search = statistics.pearson_search.get(pair.first, pair.second).coefficient
        known = pair.lower is not None and pair.upper is not None
        interval = f"{pair.lower:.2f} … {pair.upper:.2f}".replace("-", "−") if known else "–"
        cells = [f"{labels[pair.first].symbol}, {labels[pair.second].symbol}", _r(pair.coefficient), interval]
        rows.append((*cells, _r(search), _r(rank), str(pair.count)))
    columns = ("pair", "Pearson r", "95 % interval", "r in search coordinates", "Spearman ρ", "good fits")
    note = (
        f"Good fits: {typeset(statistics.filtered.statement)}. Below |r| = 0.5 two parameters count as not correlated."
    )
    return Table("Correlations of the good fits", columns, tuple(rows), (1, 2, 3, 4, 5), note)


def _interval(statistics: Statistics | None, name: str, doubt: str) -> str:
    """The interval of a parameter, what it rests on, and why it may not hold; a dash without one."""
    linearisation = None if statistics is None else statistics.linearisation
    interval = None if linearisation is None else linearisation.interval(name)
    if statistics is None or linearisation is None or interval is None:
        return "–"
    rests = linearisation.basis_in_words(name)
    if any(name in other.differs for other in statistics.basins.others):
        rests += ", in the first of several basins" if rests else "in the first of several basins"
    return f"{' … '.join(ends(*interval))}{rests and f', {rests}'}{doubt}"


def _optimum_tables(statistics: Statistics, labels: dict[str, ParameterLabel]) -> list[Table]:
    """Directions that the data determine or leave open, and the residuals, as far as they are known."""
    tables = []
    linearisation = statistics.linearisation
    if linearisation is not None:
        rows = []
        for c in linearisation.combinations:
            parts = ", ".join(f"{labels[name].symbol}: {_r(part)}" for name, part in c.components.items())
            rows.append((number(c.singular_value, 3), parts, "left open" if c.open else "determined"))
        note = (
            "Directions at the optimum, the best determined first; parts are moves of each parameter in units of its "
            f"search range. Relative error of the derivatives: {number(linearisation.derivative_error, 2)}."
        )
        columns = ("singular value", "combination", "the data")
        tables.append(Table("Combinations of parameters at the optimum", columns, tuple(rows), (0,), note))
        if linearisation.without is not None and not linearisation.without.fitted:
            tables.append(left_out_table(linearisation.without, labels))
    if statistics.residuals:
        tables.append(residual_table(statistics))
    return tables


def _notes(problem: Problem, statistics: Statistics) -> tuple[str, ...]:
    threshold = statistics.filtered.threshold
    how = "given" if threshold.origin == "given" else f"proposed, {threshold.explanation}"
    notes = [f"Good fits: {statistics.filtered.statement}. The threshold was {how}."]
    if statistics.samples.source == "mixed":
        notes.append("Widths and correlations come from the Monte Carlo samples only; the swarm's are biased.")
    if statistics.samples.failed:
        notes.append(f"{statistics.samples.failed} evaluations failed and are left out.")
    notes += not_modelled(problem)
    if statistics.fit.kind == "untested":  # all else stands at the head
        notes += [statistics.fit.sentence, *(remedy.text for remedy in statistics.fit.remedies)]
    warnings = [warning[:1].upper() + warning[1:] for warning in statistics.warnings]
    return (*notes, *warnings, *(remedy.text for remedy in statistics.basins.remedies))


def _r(value: float | None) -> str:
    return "–" if value is None else f"{value:.2f}".replace("-", "−")


def _provenance(problem: Problem, record: RunRecord) -> dict[str, str]:
    run = record.versions
    found = {
        "problem": problem.name,
        "job": record.id or "run in process",
        "forward model": problem.forward_model.kind.replace("_", " "),
        "method": method_in_words(problem),
        "seed": str(record.seed),
        "evaluations": f"{record.evaluations} in {record.generations} generations, {record.failed} failed",
        "state": record.state,
        "calculated with": "not recorded" if run is None else _listed(run),
        "report made with": _listed(record.environment),
    }
    if record.warnings:
        found["warning"] = "; ".join(record.warnings)
    if record.finished_at is not None:
        found["finished"] = f"{record.finished_at:%Y-%m-%d %H:%M:%S} UTC"
    if record.best is not None:
        found["best evaluation"] = f"generation {record.best.generation}, particle {record.best.particle}"
    return found


def _listed(versions: Mapping[str, str]) -> str:
    return ", ".join(f"{name} {number}" for name, number in versions.items())


def _quantity(value: float | None, unit: str) -> str:
    text = number(value)
    return text if value is None or unit in ("", "-") else f"{text} {unit}"


def _listing(document: dict[str, Any]) -> str:
    """JSON with one line an item of each section."""
    lines = []
    for key, value in document.items():
        if isinstance(value, dict) and value:
            inner = (f"  {json.dumps(name)}: {json.dumps(item, ensure_ascii=False)}" for name, item in value.items())
            lines.append(f"{json.dumps(key)}: {{\n" + ",\n".join(inner) + "\n}")
        else:
            lines.append(f"{json.dumps(key)}: {json.dumps(value, ensure_ascii=False)}")
    return "{\n" + ",\n".join(lines) + "\n}"


def _short(document: dict[str, Any]) -> dict[str, Any]:
    """The problem without the measured points, which the tables and the problem file have."""
    observations = document["observations"]
    kept = [
        {key: value for key, value in o.items() if key != "points"} | {"points": f"{len(o['points']['x'])} points"}
        for o in observations
    ]
    return document | {"observations": kept}
