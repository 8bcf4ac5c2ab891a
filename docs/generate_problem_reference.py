"""Writes docs/problem-file.md from the models of the problem file and the forward models' own descriptions.

Run ``python docs/generate_problem_reference.py`` after a change of them; a test compares the page with the models.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from geoswarm.solver.methods.base import Role
from geoswarm.solver.methods.registry import BUILT_IN, find_method, kinds_of

ROOT = Path(__file__).parents[1]
PAGE = ROOT / "docs" / "problem-file.md"
KINDS = (
    *(
        "oedometer",
        "isotropic_compression",
        "crs_oedometer",
        "consolidation",
        "triaxial",
        "direct_simple_shear",
        "column",
        "section",
        "finite_element",
    ),
    *("formula", "combined", "python", "command", "umbridge", "registered"),
)
EXAMPLES = {"oedometer": "oedometer", "isotropic_compression": "isotropic_compression", "section": "slope"}
LABORATORY = ("crs_oedometer", "consolidation", "triaxial", "direct_simple_shear")
"""Tests on any law, whose parameters and series are told for the example of their kind."""

INTRODUCTION = """\
# The problem file

A problem says what to calculate, what to identify, what was measured, how to search and when to stop. It is one YAML
(`.yaml`, `.yml`) or JSON (`.json`) file; the same object, with its files inlined, is the body of `POST /api/v1/jobs`.

```yaml
{example}```

- YAML is read as YAML 1.2 (`1e-7` is a number, `yes` is text); a key that is given twice is an error.
- Numbers are numbers: `"3"` and `true` are refused where a number is wanted, and so are NaN and infinity.
- Every mistake is reported with its path, such as `parameters.c.lower`, and all of them at once.
- A problem file has at most {yaml_size} MB as YAML and {json_size} MB as JSON, a CSV or XLSX file {table_size} MB,
  an expression {length} characters.
"""

PARAMETERS = """\
A parameter is exactly one of free, fixed and linked. Which parameters there are, which of them are needed, and within
what limits depends on the forward model. A parameter that the forward model does not know is only accepted when a
linked parameter uses it.

The order counts: a search deals its random numbers out to the free parameters in the order of the file. With the same
seed, another order gives another history, which is as good as any other seed's.
"""

CONSTRAINTS = """\
A constraint is a comparison of parameters. Every proposal of the search satisfies all of them, the first included. A
problem is refused when no admissible point is found between the bounds: the estimates, the centre, the corners (up to
ten free parameters) and {points} random points are tried.

### Expressions

Numbers, names of parameters, `pi`, `+ - * / **`, brackets, comparisons `< <= > >= == !=` (also chained: `1 < a < 2`),
`and`, `or`, `not`, and the functions below; precedence is that of Python. A power is written `a**b`. What has no value
(`1 / 0`, `ln(-1)`) makes a proposal inadmissible, and a comparison with it never holds.

{functions}
"""

FOLLOW_UP = """\
### Follow-ups

The methods below evaluate more about the optimum of a job that has ended, or about the whole space between the bounds.
`geoswarm sensitivity`, `profile` and `influence` write and submit such problems. They end by themselves; a criterion
under `stopping` ends them earlier.
"""

OBSERVATIONS = """\
Each observation gives measured points of one series; a series is given once. A second specimen of the same test is a
further part of `kind: combined`. Objectives are in the series' base units squared, whatever the units of the data.

### Units

Inside, units are kN, m, day and degree. `x_unit` and `y_unit` name the units of the data and may be any unit of the
right dimension: `s`, `min`, `h`, `day`, `um`, `mm`, `cm`, `m`, `Pa`, `kPa`, `MPa`, `bar`, `kN/m^2`, `%` ...

Without them, points in the problem file have the base unit of the series, and the columns of a file have the unit that
the file names: in the heading (`settlement [mm]`, `Setzung 1/100 mm (korr.)`, `Zeit in Minuten`), in a row of units
below the names, in each cell (`0.5 %`), in the format of the cells, or in a comment (`# x in min, y in mm`). German and
English words and units such as `kg/cm2`, `t/m²`, `psf` and `‰` are known. A unit that is not known, several units in
one heading, a unit of another dimension and a column without any unit are errors; only numbers without dimension need
none. A client that sends the readings of a file without a unit to a service gives the unit `unstated`, so that the
service refuses them, too.

### CSV and XLSX files

The problem file, the command line and the form at `/new` read files alike. The header is the first line with the
columns that are asked for, above rows of numbers; titles, lines of a machine and `#` comments above it do not matter. A
workbook is read from its first sheet with cells, or from `sheet`. The header names the columns `x`, `y` and, if wanted,
`weight`, in any order and in upper or lower case; other columns are ignored. Columns of other names are given by
`x_column`, `y_column` and `weight_column`, with or without the unit in the heading. A column of dates
(`2024-03-01 08:30`, `01.03.2024 08:30`) can be x: days since `x_origin`, or since the first reading. Columns of a text
file are separated by comma, semicolon, tab or blanks; except next to commas, and in quotes, numbers may have a decimal
comma. Between blanks an empty cell cannot be seen: each row must then have as many cells as the header. Times such as
`25:30:00` are days, and cells formatted as per cent are in %. A row with more cells than headings is refused: a comma
inside a number has split it. The file's path is relative to the problem file.

### Readings in disorder, or very many

`sort: true` puts readings in the order of x. Where several have one x, `repeated_x: average` takes their mean and
`shift` spreads them evenly up to the next x. No mean is taken across a load of a test in stages: different readings at
its moment need `shift`, by which the first is the one before the load. A logger's many readings become few by
`resample: {per_decade: 20}`,
means of the readings in intervals of equal length in log x, or `{every: 10}`, of so many in a row; above 20 000
points of a series a warning asks for it. Thinning does not change the weight of a series: the weights w_h of the
points follow the number of readings behind each, with a mean of 1. If the `error` of a reading is stated, that of a
mean of n readings is smaller by the root of n only if the readings scatter independently. Neighbours that differ by
less than the stated error count as fewer readings; `check` and the report say as how many. The canonical problem
contains the means, with `readings`, `independent`, and the `range` of the readings for `weighting: by_range`.
"""

STOPPING = """\
A job ends after the generation in which a criterion is satisfied; all satisfied ones are reported.
"""


ANSWER = """
When a search ends, the job goes on with the runs that its result needs: the last steps to the minimum, sensitivities
and intervals there, a look at other basins that the search came across, and profiles where the model is nonlinear.
They follow every search: swarms, with and without a response surface, and differential evolution. `max_evaluations` and
`max_seconds` of `stopping` hold for the whole job: the search leaves 15 evaluations for each free parameter to these
runs, and at most a quarter of evaluations and time; one without a response surface leaves a quarter. See
[statistics](statistics.md).

```yaml
answer: {max_evaluations: 40}
```
"""

LIMITS = """
What one evaluation may use, in the service and in `geoswarm run` on Linux (elsewhere it says that it cannot). Whoever
exceeds a limit is killed with all processes that it has started, and the evaluation has failed. The service may have
tighter limits.

```yaml
limits: {seconds_per_evaluation: 600, memory_mb: 2000}
```
"""

FAILURES = """
A failed evaluation is data: it has a reason, the search treats it as infinitely bad and continues. A job without one
success ends failed, and that after its first generation if a program fails in all of it (five runs or more that are
`not_started`, `program_failed`, `no_output` or `bad_output`).

| reason | meaning |
| --- | --- |
| `diverged` | the calculation found no solution |
| `not_finite` | it gave NaN or infinity |
| `infeasible` | the parameters make no sense together |
| `bad_output` | what it gave cannot be read, or the model is broken |
| `timeout`, `killed_memory` | it exceeded a limit |
| `worker_lost` | its process or its worker ended |
| `not_started`, `program_failed`, `no_output`, `no_licence` | of a [program](programs.md) |

```yaml
failures:
  retry: {timeout: 1, worker_lost: 3}   # further tries
  policy: {bad_output: fail}            # such a failure ends the job; others are penalised
```
"""


WARM_START = """
Runs of earlier jobs are taken over when the `forward_model` section is the same, their curves have all points that are
observed now, and their parameters are a point of this search. They cost nothing; see [how the search works](search.md).
"""


INDEX_PROPERTIES = """
Index properties of the soil take no part in the calibration. Published correlations tell what they let expect of the
parameters: `geoswarm estimate`, `check`, the form and the report show it. See [starting values](index-properties.md).

```yaml
index_properties: {liquid_limit: 65, plastic_limit: 28, water_content: 52, soil_class: inorganic_clay}   # per cent
```
"""


def main() -> None:
    """Write the page."""
    PAGE.write_text(page(), encoding="utf-8")


def methods(role: Role, definitions: dict[str, Any]) -> list[str]:
    """Tables of the keys of the built-in methods with a role."""
    kinds = [kind for kind in kinds_of(role) if kind in BUILT_IN]
    return [f"### kind: {kind}\n\n{fields(definitions[find_method(kind).__name__], definitions)}" for kind in kinds]


def page() -> str:
    """The page as it follows from the models."""
    from geoswarm.solver.expressions import FUNCTIONS, MAX_LENGTH
    from geoswarm.solver.problem import MAX_BYTES, MAX_TABLE_BYTES, problem_schema
    from geoswarm.solver.problem.checks.feasibility import TRIED_POINTS

    schema = problem_schema(programs=True)
    definitions = schema["$defs"]
    introduction = INTRODUCTION.format(
        example=(ROOT / "examples" / "oedometer" / "problem.yaml").read_text(encoding="utf-8"),
        yaml_size=MAX_BYTES["yaml"] // 2**20,
        json_size=MAX_BYTES["json"] // 2**20,
        table_size=MAX_TABLE_BYTES // 2**20,
        length=MAX_LENGTH,
    )
    functions = table(
        ("function", "meaning"),
        ((f"`{f.name}`", f.description) for f in FUNCTIONS.values()),
    )
    order = (
        *("name", "forward_model", "parameters", "constraints", "observations", "weighting", "noise", "method"),
        *("stopping", "seed", "answer", "limits", "failures", "priority", "warm_start", "index_properties", "accept"),
    )
    sections = [
        f"<!-- Generated by docs/{Path(__file__).name}; change the models, not this page. -->",
        introduction,
        "## Sections",
        fields(schema, definitions, order),
        "## parameters",
        PARAMETERS,
        *(
            f"### {form.capitalize()}\n\n{fields(definitions[f'{form.capitalize()}Section'], definitions)}"
            for form in ("free", "fixed", "linked")
        ),
        "## constraints",
        CONSTRAINTS.format(points=f"{TRIED_POINTS:,}".replace(",", " "), functions=functions),
        "## observations",
        OBSERVATIONS,
        "### Keys",
        fields(definitions["ObservationSection"], definitions),
        "### points",
        fields(definitions["PointsSection"], definitions),
        "## method",
        *methods("search", definitions),
        *methods("sampling", definitions),
        FOLLOW_UP,
        *methods("follow_up", definitions),
        "## noise",
        "How intervals take it into account: [statistics](statistics.md#what-intervals-allow-for).",
        fields(definitions["NoiseSection"], definitions),
        "## stopping",
        STOPPING,
        fields(definitions["Stopping"], definitions),
        "## answer",
        ANSWER,
        fields(definitions["Answering"], definitions),
        "## limits",
        LIMITS,
        fields(definitions["Limits"], definitions),
        "## failures",
        FAILURES,
        fields(definitions["Failures"], definitions),
        "## warm_start",
        WARM_START,
        fields(definitions["WarmStart"], definitions),
        "## index_properties",
        INDEX_PROPERTIES,
        fields(definitions["IndexSection"], definitions),
        "## forward_model",
        *(forward_model(kind, definitions) for kind in KINDS),
    ]
    return "\n\n".join(section.strip("\n") for section in sections) + "\n"


def forward_model(kind: str, definitions: dict[str, Any]) -> str:
    """The part of the page about one kind of forward model."""
    from geoswarm.solver.forward.registry import find_spec, parse_spec
    from geoswarm.solver.problem import read_document
    from geoswarm.solver.problem.text.writing import problem_yaml

    schema = definitions[f"forward_model_{kind}"]
    parts = [f"### kind: {kind}", schema["description"].replace("``", "`"), fields(schema, definitions)]
    below = f"forward_model_{kind}_"
    for name, definition in definitions.items():
        shared = kind == "finite_element" and f"forward_model_section_{name.removeprefix(below)}" in definitions
        if name.startswith(below) and not shared:
            users = [definitions[f"forward_model_{kind}"], *definitions.values()]
            used_by, rule = next(
                item for user in users for item in user.get("properties", {}).items() if name in str(item[1])
            )
            law = definition["properties"].get("law", {}).get("const")
            each = "Each entry" if rule.get("type") in ("array", "object") else "Keys"
            what = f"{each} of `{used_by}`" if law is None else f"An entry of `{used_by}` with law `{law}`"
            parts += [f"{what}: {first_line(definition)}", fields(definition, definitions)]
    if kind == "formula":
        parts.append(
            "Every name in an expression other than `x` is a parameter, without limits, or a further quantity that was "
            "measured at the points: `inputs: {T: temperature}` in the observation of the series names its "
            "column, whose numbers the expression gets unchanged."
        )
    elif kind == "combined":
        parts.append(
            "Series are named `part.series`. Parts share parameters by name; a parameter `part.name` is the value for "
            "that part alone and goes before the shared one."
        )
    elif kind == "python":
        parts.append(
            "The arguments of the function are the parameters; an argument `x` receives the observed points. It is "
            "accepted by `geoswarm run` and Python, never by a service. What the function returns: [Python](python.md)."
        )
    elif kind == "command":
        parts.append(
            "Parameters are the names in the templates. It is accepted by `geoswarm run` and Python, never by a "
            "service. All about it, with examples: [Programs](programs.md)."
        )
    elif kind == "umbridge":
        parts.append(
            "Parameters are the names in `inputs`. It is accepted by `geoswarm run` and Python, never by a service. "
            "Failures, and the other direction: [UM-Bridge](umbridge.md)."
        )
    elif kind == "registered":
        parts.append(
            "Parameters, series and settings are those that the operator has declared; `geoswarm models show` and the "
            "form of a new job list them. See [Programs](programs.md)."
        )
    elif kind == "finite_element":
        parts.append("What is not told here is as for `section`. Parameters are the names in the expressions.")
    elif kind == "column":
        example = (ROOT / "examples" / "column" / "problem.yaml").read_text(encoding="utf-8")
        model = parse_spec(read_document(example, "yaml")["forward_model"]).build()
        parts += [
            "What all of it means: [layered ground](column.md). In examples/column the parameters are:",
            parameters(model.parameters),
            "Series:",
            series(model.series),
        ]
    elif kind in LABORATORY:
        section = find_spec(kind).example() or {}
        known = parse_spec(section).build().series
        repeated = ("time_", "stage_", "branch_", "cycle_")
        water = kind in ("crs_oedometer", "consolidation")
        states = "" if water else ", and the state variables of the law come to all of them"
        parts += [
            f"Parameters are those of the law{', `k` and `C_k`' if water else ''}. For example:",
            f"```yaml\n{problem_yaml({'forward_model': section}).strip()}\n```",
            "Its series, where those over time (`time_`), stages (`stage_`, `branch_2.`) and cycles (`cycle_`) have "
            f"the same names after their prefix{states}; what they mean: [laboratory tests](laboratory-tests.md).",
            series(info for info in known if not info.name.startswith(repeated)),
        ]
    else:
        example = (ROOT / "examples" / EXAMPLES[kind] / "problem.yaml").read_text(encoding="utf-8")
        model = parse_spec(read_document(example, "yaml")["forward_model"]).build()
        if kind == "section":
            parts.append("Parameters are the names in the expressions. In examples/slope they and the series are:")
        parts += ["Parameters:", parameters(model.parameters), "Series:", series(model.series)]
    return "\n\n".join(parts)


def first_line(definition: dict[str, Any]) -> str:
    """The first line of a section's description, as the continuation of a sentence."""
    text = definition.get("description", "").splitlines()[0].removesuffix(".").replace("``", "`")
    return text[:1].lower() + text[1:]


def parameters(infos: Iterable[Any]) -> str:
    """Table of a forward model's parameters."""
    rows = (
        (
            f"`{info.name}`",
            info.unit or "1",
            "needed" if info.default is None else f"{info.default:g}",
            limits(info),
            "" if info.typical is None else f"{info.typical[0]:g} to {info.typical[1]:g}",
            sentence(info.description) + (f" Usual range: {info.source}." if info.source else ""),
        )
        for info in infos
    )
    return table(("parameter", "unit", "default", "limits", "typical", "meaning"), rows)


def limits(info: Any) -> str:
    """Admissible values of a parameter in words."""
    lower = "" if info.lower is None else f"{'above' if info.lower_open else 'from'} {info.lower:g}"
    upper = "" if info.upper is None else f"{'below' if info.upper_open else 'to'} {info.upper:g}"
    return " ".join(words for words in (lower, upper) if words)


def series(infos: Iterable[Any]) -> str:
    """Table of a forward model's series."""
    rows = (
        (
            f"`{info.name}`",
            f"{info.x_quantity}{f' [{info.x_unit}]' if info.x_unit else ''}",
            f"{info.y_quantity}{f' [{info.y_unit}]' if info.y_unit else ''}",
            sentence(info.description),
        )
        for info in infos
    )
    return table(("series", "x", "y", "meaning"), rows)


def fields(schema: dict[str, Any], definitions: dict[str, Any], order: Sequence[str] | None = None) -> str:
    """Table of the keys of a section."""
    required = set(schema.get("required", ()))
    rows = []
    for key in order or schema["properties"]:
        rule = schema["properties"][key]
        given = "needed" if key in required or key == "kind" else default(rule.get("default"))
        rows.append((f"`{key}`", kind_of(rule, definitions), given, sentence(rule.get("description", ""))))
    return table(("key", "value", "default", "meaning"), rows)


def default(value: Any) -> str:
    """Default of a key; sections have none to show."""
    if value is None or value == "":
        return ""
    if isinstance(value, dict):
        return f"kind {value['kind']}" if "kind" in value else ""
    return "empty" if value == [] else f"`{number(value) if isinstance(value, float) else value}`"


def kind_of(rule: dict[str, Any], definitions: dict[str, Any]) -> str:
    """What a key's value may be, in words."""
    if "$ref" in rule:
        return "mapping"
    if "const" in rule:
        return f"`{rule['const']}`"
    if "enum" in rule:
        return " or ".join(f"`{value}`" for value in rule["enum"])
    for choice in ("anyOf", "oneOf"):
        if choice in rule:
            words = (kind_of(part, definitions) for part in rule[choice] if part.get("type") != "null")
            return " or ".join(dict.fromkeys(words))
    if rule.get("type") == "array":
        if "items" not in rule or "prefixItems" in rule.get("items", {}):
            return "points" if "items" in rule else "pair of numbers"
        return f"list of {plural(kind_of(rule['items'], definitions))}"
    if rule.get("type") == "object":
        return "mapping"
    names = {"string": "text", "number": "number", "integer": "whole number", "boolean": "true or false"}
    return f"{names[rule['type']]}{bounds(rule)}"


def plural(words: str) -> str:
    """The plural of a kind of value."""
    if words.startswith("whole number"):
        return words.replace("whole number", "whole numbers", 1)
    noun, _, rest = words.partition(" ")
    return words if noun == "text" else f"{noun}s{f' {rest}' if rest else ''}"


def bounds(rule: dict[str, Any]) -> str:
    """Limits of a number in words."""
    words = {"exclusiveMinimum": "above", "minimum": "from", "exclusiveMaximum": "below", "maximum": "to"}
    return "".join(f" {word} {number(rule[key])}" for key, word in words.items() if key in rule)


def sentence(text: str) -> str:
    """A description as a sentence without its full stop, safe inside a table."""
    text = " ".join(text.split()).removesuffix(".").replace("|", "\\|").replace("*", "\\*")
    first = text.partition(" ")[0]
    # Symbols and values keep their case.
    return text if len(first.rstrip(";")) == 1 or first.endswith(":") else text[:1].upper() + text[1:]


def number(value: float) -> str:
    """A number with all its digits: 1, not 1.0."""
    return repr(value).removesuffix(".0")


def table(header: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A Markdown table."""
    lines = [header, ["---"] * len(header), *rows]
    return "\n".join(f"| {' | '.join(cells)} |" for cells in lines)


if __name__ == "__main__":
    sys.path.insert(0, str(ROOT))
    main()
