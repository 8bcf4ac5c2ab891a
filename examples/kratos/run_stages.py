"""Runs the stages of the embankment with Kratos Geomechanics, one after the other, and writes readings.csv.

Called by geoswarm in a new folder for each set of parameters; it is run by the Python that Kratos is installed for, and
imports nothing else. kN, m, day; a density of Kratos is a unit weight here, because its acceleration is 1.
"""

from __future__ import annotations

import csv
import json
from pathlib import Path
from typing import Any

import KratosMultiphysics as Kratos
from KratosMultiphysics.GeoMechanicsApplication import TOTAL_DISPLACEMENT
from KratosMultiphysics.GeoMechanicsApplication.geomechanics_analysis import GeoMechanicsAnalysis

GROUND, LIFTS = ("clay", "sand"), ("lift_1", "lift_2", "lift_3")
POINTS = ("axis", "middle", "toe")


def process(module: str, name: str, **parameters: Any) -> dict[str, Any]:
    """A process of Kratos Geomechanics."""
    return {
        "python_module": module,
        "kratos_module": "KratosMultiphysics.GeoMechanicsApplication",
        "process_name": name,
        "Parameters": parameters,
    }


def vector(part: str, variable: str, active: list[bool], value: list[float], **more: Any) -> dict[str, Any]:
    """A vector that is given for some nodes."""
    return process(
        "apply_vector_constraint_table_process",
        "ApplyVectorConstraintTableProcess",
        model_part_name=f"Ground.{part}",
        variable_name=variable,
        active=active,
        value=value,
        table=[0, 0, 0],
        **more,
    )


def held(part: str, directions: list[bool]) -> dict[str, Any]:
    """Displacements that are zero."""
    return vector(part, "DISPLACEMENT", directions, [0.0, 0.0, 0.0], is_fixed=directions)


def stage(number: int) -> dict[str, Any]:
    """Settings of a stage: 0 is the weight of the ground, 1 to 3 place a lift each."""
    dry = process(
        "apply_scalar_constraint_table_process",
        "ApplyScalarConstraintTableProcess",
        model_part_name="Ground.porous_computational_model_part",
        variable_name="WATER_PRESSURE",
        is_fixed=True,
        fluid_pressure_type="Uniform",
        value=0.0,
        table=0,
    )
    placed = [
        process(
            "apply_excavation_process",
            "ApplyExcavationProcess",
            model_part_name=f"Ground.{lift}",
            deactivate_soil_part=later > number,
        )
        for later, lift in enumerate(LIFTS, start=1)
    ]
    parts = [*GROUND, *LIFTS]
    return {
        "problem_data": {
            "problem_name": f"stage_{number}",
            "start_time": float(number),
            "end_time": float(number + 1),
            "echo_level": 0,
            "parallel_type": "OpenMP",
            "number_of_threads": 1,
        },
        "solver_settings": {
            "solver_type": "U_Pw",
            "model_part_name": "Ground",
            "domain_size": 2,
            "model_import_settings": {"input_type": "mdpa", "input_filename": "embankment"},
            "material_import_settings": {"materials_filename": "materials.json"},
            "time_stepping": {"time_step": 1.0},
            "reset_totals": number < 2,  # displacements count from the first lift on
            "solution_type": "Quasi-Static",
            "scheme_type": "Backward_Euler",
            "strategy_type": "newton_raphson",
            "convergence_criterion": "displacement_criterion",
            "displacement_relative_tolerance": 1.0e-8,
            "displacement_absolute_tolerance": 1.0e-12,
            "reform_dofs_at_each_step": True,
            "linear_solver_settings": {"solver_type": "LinearSolversApplication.sparse_lu"},
            "problem_domain_sub_model_part_list": parts,
            "processes_sub_model_part_list": ["sides", "base", *POINTS],
            "body_domain_sub_model_part_list": parts,
        },
        "output_processes": {},
        "processes": {
            "constraints_process_list": [held("sides", [True, False, True]), held("base", [True] * 3), dry, *placed],
            "loads_process_list": [
                vector(
                    "porous_computational_model_part",
                    "VOLUME_ACCELERATION",
                    [False, True, False],
                    [0.0, -1.0, 0.0],
                )
            ],
        },
    }


def main() -> None:
    """Run all stages."""
    Kratos.Logger.GetDefaultOutput().SetSeverity(Kratos.Logger.Severity.WARNING)
    model, rows = Kratos.Model(), []
    for number in range(len(LIFTS) + 1):
        GeoMechanicsAnalysis(model, Kratos.Parameters(json.dumps(stage(number)))).Run()
        moved = []
        for point in POINTS:
            (node,) = model[f"Ground.{point}"].Nodes
            moved += list(node.GetSolutionStepValue(TOTAL_DISPLACEMENT))[:2]
        if number > 0:
            rows.append([number, *moved])
    with Path("readings.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(["day", *(f"{point}_{axis}" for point in POINTS for axis in ("ux", "uy"))])
        writer.writerows(rows)
    print("All stages are done.")


if __name__ == "__main__":
    main()
