"""Commented problems to begin with, one a kind of forward model; data beside them that are to be replaced."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

__all__ = ["STARTERS", "Starter"]


@dataclass(frozen=True, slots=True)
class Starter:
    """A problem to begin with.

    Parameters
    ----------
    example
        Its data are those of this example.
    text
        The problem file; that of the example, under a comment, when empty.
    headings
        Line of headings of each data file, where they are not those of the example.
    files
        Further data files.
    """

    example: str
    text: str = ""
    headings: Mapping[str, str] = field(default_factory=dict)
    files: Mapping[str, str] = field(default_factory=dict)


_COMMON = """\
method: {kind: particle_swarm, particles: 10}
stopping:                               # the first criterion that is satisfied ends the search
  max_evaluations: 400
  stagnation_generations: 20
seed: 1                                 # the same seed, the same result
"""

_OEDOMETER = (
    """\
# An oedometer test. Replace the stages and settlement.csv by yours, then: geoswarm check problem.yaml
# All keys: docs/problem-file.md. Units inside are kN, m, day, degree.
name: my-oedometer
forward_model:
  kind: oedometer
  material: soft_soil_creep
  height: 0.02                          # m, of the specimen
  initial_stress: 0.2                   # kPa, vertical, before the first stage
  stages:                               # vertical stress [kPa] and how long it is held [day]
    - {stress: 9, duration: 2}
    - {stress: 13, duration: 1}
    - {stress: 25, duration: 1}
    - {stress: 50, duration: 1}
    - {stress: 100, duration: 1}
    - {stress: 200, duration: 1}
    - {stress: 400, duration: 1}
    - {stress: 800, duration: 1}
    - {stress: 400, duration: 1}        # unloading
    - {stress: 200, duration: 1}
    - {stress: 100, duration: 1}
    - {stress: 50, duration: 1}
    - {stress: 100, duration: 1}        # reloading
    - {stress: 200, duration: 1}
    - {stress: 400, duration: 1}
    - {stress: 800, duration: 1.8}
parameters:                             # free: lower and upper; fixed: value; linked: expression
  lambda_star: {lower: 0.002, upper: 1.0, scale: log}
  kappa_star: {lower: 0.001, upper: 0.5, scale: log}
  mu_star: {value: 1.46e-3}
  c: {lower: 0.001, upper: 100}         # kPa
  phi: {value: 20}                      # degree
  psi: {value: 0}
constraints: ["lambda_star > kappa_star"]
observations:
  # Only the ends of the stages were read? series: stage_settlement over their number 1, 2, ... or their load [kPa]
  - series: settlement                  # over the time since the first stage
    file: settlement.csv                # CSV or XLSX; units are taken from the headings
    x_column: time
    y_column: settlement
    # error: 0.05                       # standard deviation of a reading, in mm, where you know it
    # sort: true                        # readings in any order
    # repeated_x: average               # several readings at one time
    # resample: {per_decade: 20}        # a logger's many readings
"""
    + _COMMON
)

_FORMULA = (
    """\
# A curve fit: any formula of x and parameters. Replace it and settlement.csv, then: geoswarm check problem.yaml
# All keys and functions: docs/problem-file.md.
name: my-formula
forward_model:
  kind: formula
  series:
    settlement:
      expression: s_end * x / (t_half + x)    # every name but x is a parameter
      x_unit: day                             # of x inside the formula
      y_unit: m                               # of its value
parameters:                             # free: lower and upper; fixed: value; linked: expression
  s_end: {lower: 0.05, upper: 5.0, scale: log}
  t_half: {lower: 5, upper: 2000, scale: log}
observations:
  - series: settlement
    file: settlement.csv                # CSV or XLSX; units are taken from the headings
    x_column: time
    y_column: settlement
    # inputs: {T: temperature}          # a further column that the formula uses as T
    # error: 0.5                        # standard deviation of a reading, in cm, where you know it
"""
    + _COMMON
)

_TESTS = (
    """\
# Many tests of one sand: tests.csv has a row for each, and each has a file of readings. Replace them by yours, then:
# geoswarm check problem.yaml. All columns: docs/laboratory-files.md, A table of tests.
name: my-tests
tests:
  table: tests.csv                      # CSV, XLSX or ODS
  material: hypoplastic_sand            # of every test, as every other key here
  # back_pressure: 300                  # kPa
parameters:                             # free: lower and upper; fixed: value; linked: expression
  phi_c: {value: 33}                    # degree
  h_s: {lower: 1.0e+5, upper: 4.0e+7, scale: log}   # kPa; geoswarm estimate problem.yaml suggests values
  n: {lower: 0.15, upper: 0.5}
  e_c0: {lower: 0.9, upper: 1.2}
  e_d0: {expression: 0.64 * e_c0}
  e_i0: {expression: 1.15 * e_c0}
  alpha: {lower: 0.05, upper: 0.4}
  beta: {lower: 0.8, upper: 4}
# weighting: by_test                    # every test counts alike; the default of a table
"""
    + _COMMON
)

_SYNTHETIC = "# SYNTHETIC readings, to be replaced with yours\n"
_TEST_FILES = {
    "tests.csv": """\
name,file,kind,cell pressure [kPa],initial void ratio
OE1,oe1.csv,oedometer,,
TD1,td1.csv,triaxial drained,100,0.75
TU1,tu1.csv,triaxial undrained,200,0.9
""",
    "oe1.csv": _SYNTHETIC
    + """\
vertical stress [kPa],void ratio
10,0.95
20,0.9453
50,0.9378
100,0.9309
200,0.9224
400,0.9118
800,0.8993
200,0.9046
50,0.9087
""",
    "td1.csv": _SYNTHETIC
    + """\
axial strain [%],q [kPa],volumetric strain [%]
0.25,89.0,0.18
0.5,159.5,0.26
1,255.3,0.3
2,349.0,0.07
3,378.5,-0.27
4,380.0,-0.67
6,364.4,-1.48
8,346.1,-2.21
10,337.0,-2.87
15,308.0,-4.31
20,294.1,-5.52
""",
    "tu1.csv": _SYNTHETIC
    + """\
axial strain [%],q [kPa],pore pressure [kPa]
0.25,78.0,96.0
0.5,98.0,127.6
1,109.4,147.1
2,130.5,148.8
3,151.7,142.9
4,167.1,134.0
6,217.0,115.5
8,263.0,94.7
10,318.6,73.6
""",
}

STARTERS: dict[str, Starter] = {
    "oedometer": Starter("oedometer", _OEDOMETER, {"settlement.csv": "time [min],settlement [mm]"}),
    "isotropic_compression": Starter("isotropic_compression"),
    "triaxial": Starter("triaxial"),
    "direct_simple_shear": Starter("direct_simple_shear"),
    "consolidation": Starter("consolidation"),
    "crs_oedometer": Starter("crs_oedometer"),
    "column": Starter("column"),
    "formula": Starter("formula", _FORMULA, {"settlement.csv": "time [day],settlement [cm]"}),
    "combined": Starter("combined"),
    "section": Starter("slope"),
    "tests": Starter("triaxial", _TESTS, files=_TEST_FILES),
}
"""Problems to begin with, by kind of forward model; ``tests``: a table of tests."""
