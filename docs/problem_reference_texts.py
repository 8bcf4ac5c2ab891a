"""What docs/problem-file.md says beside its generated tables; docs/generate_problem_reference.py writes the page."""

from __future__ import annotations

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
`geoswarm sensitivity`, `profile`, `jackknife` and `influence` write and submit such problems. They end by themselves; a
criterion under `stopping` ends them earlier.
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
one heading, a unit of another dimension and a column without any unit are errors. Numbers without dimension need none,
such as void ratios; strains do, `%` or `[-]`.
A client that sends the readings of a file without a unit to a service gives the unit `unstated`, so that the
service refuses them, too.

### CSV and XLSX files

The problem file, the command line and the form at `/new` read files alike. The header is the first line with the
columns that are asked for, above rows of numbers; titles, lines of a machine and `#` comments above it do not matter. A
workbook is read from `sheet`, or from the only sheet that has columns of these names; several such sheets are an error,
and where there is none, the first with cells is read. The header names the columns `x`, `y` and, if wanted,
`weight`, in any order and in upper or lower case; other columns are ignored. Columns of other names are given by
`x_column`, `y_column` and `weight_column`, with or without the unit in the heading. A column of dates
(`2024-03-01 08:30`, `01.03.2024 08:30`) can be x: days since `x_origin`, or since the first reading. Columns of a text
file are separated by comma, semicolon, tab or blanks; except next to commas, and in quotes, numbers may have a decimal
comma. Between blanks an empty cell cannot be seen: each row must then have as many cells as the header. Times such as
`25:30:00` are days, and cells formatted as per cent are in %. A row with more cells than headings is refused: a comma
inside a number has split it. The file's path is relative to the problem file. `blocks` joins several parts of a file,
such as stages side by side: see [laboratory files](laboratory-files.md#several-blocks-of-a-file).

### Readings in disorder, or very many

`sort: true` puts readings in the order of x. Where several have one x, `repeated_x: average` takes their mean and
`shift` spreads them evenly up to the next x. No mean is taken across a load of a test in stages: different readings at
its moment need `shift`, by which the first is the one before the load. Several gauges can be averaged there, too, if
every x has a reading of each: as many readings at the load are those before it; of twice as many the first half, and
the mean of the others is placed halfway to the next x, as by `shift`. A logger's many readings become few by
`resample: {per_decade: 20}`,
means of the readings in intervals of equal length in log x, or `{every: 10}`, of ten consecutive readings; above 20 000
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


TESTS = """
A table with a row for each laboratory test: [how to write it](laboratory-files.md#a-table-of-tests). Each row becomes
a part of `kind: combined` with the observations of its file; a mistake names row and column. `forward_model` may hold
further parts, `observations` those of them. Unless `weighting` is given, it is `by_test`: every test counts alike.

Any key of the table except `table`, `table_sheet` and `rows` holds for every row that does not give it. In addition to
the keys below, a row has

- the keys of its part, such as `material` (needed), `settings`, `height` or `back_pressure`;
- the columns of its series by name: `void_ratio` or `axial_strain` (oedometer), `void_ratio` or `volumetric_strain`
  (isotropic_compression), `q`, `p`, `volumetric_strain`, `pore_pressure`, `void_ratio`, `stress_ratio`,
  `radial_strain`, `axial_stress` or `radial_stress` over the axial strain (triaxial). With `_unit`, `_factor`,
  `_error`, `_weight` or `_distance` behind the name: `q_error: 2`, `q_distance: orthogonal`;
- of the keys of an observation: `decimal_sign`, `incomplete_rows`, `no_reading`, `where`, `sort`, `repeated_x`,
  `resample`, `y_zero`, `gross_error_column`, `x_factor`, `loss` and `loss_scale`, and of shearing `x_from` and `x_to`.
"""

INDEX_PROPERTIES = """
Index properties of the soil take no part in the calibration. Published correlations tell what they let expect of the
parameters: `geoswarm estimate`, `check`, the form and the report show it. See [starting values](index-properties.md).

```yaml
index_properties: {liquid_limit: 65, plastic_limit: 28, water_content: 52, soil_class: inorganic_clay}   # per cent
```
"""
