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
    """

    example: str
    text: str = ""
    headings: Mapping[str, str] = field(default_factory=dict)


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
}
"""Problems to begin with, by kind of forward model."""
