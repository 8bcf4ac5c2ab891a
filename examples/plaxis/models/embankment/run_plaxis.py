"""Runs one PLAXIS 2D project through its remote scripting server: parameters.json in, results.csv out.

Adapt what is in capitals to your project. ``plxscripting`` comes with PLAXIS: run this with the Python of PLAXIS, or
one in which you have installed it. Called as ``run_plaxis.py SLOT``: each slot has two ports, for Input and Output.

Exit status 3: a phase has failed; 4: PLAXIS ended before it answered, as it does where no licence is free.
"""

from __future__ import annotations

import json
import os
import socket
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

from plxscripting.easy import new_server

PROJECT = "embankment.p2dx"
FIRST_PORT = int(os.environ.get("PLAXIS_FIRST_PORT", "10000"))
START_SECONDS = 180.0
MATERIALS = {"clay": {"lambdaModified": "lambda_star", "kappaModified": "kappa_star", "muModified": "mu_star"}}
POINTS = ("A", "B")  # names for the nodes that are selected for curves in the project, in their order there
PHASES = ("Consolidation",)  # the phases whose steps are read, by their identification


class NoAnswerError(Exception):
    """PLAXIS ended, or did not answer in time."""


def start(port: int, password: str) -> subprocess.Popen[bytes]:
    """Start PLAXIS and wait until its scripting server listens."""
    program = os.environ["PLAXIS_PROGRAM"]  # C:\Program Files\...\Plaxis2DXInput.exe
    process = subprocess.Popen([program, f"--AppServerPassword={password}", f"--AppServerPort={port}"])
    deadline = time.monotonic() + START_SECONDS
    while time.monotonic() < deadline:
        if process.poll() is not None:
            raise NoAnswerError(f"PLAXIS ended with exit status {process.returncode} before it answered")
        try:
            socket.create_connection(("localhost", port), 1.0).close()
        except OSError:
            time.sleep(0.2)
        else:
            return process
    process.kill()
    raise NoAnswerError(f"PLAXIS did not answer within {START_SECONDS:g} s")


def calculate(g_i: Any, parameters: dict[str, float]) -> list[str]:
    """Set the materials and calculate all phases; return what has failed."""
    for material in g_i.Materials[:]:
        names = MATERIALS.get(material.Name.value, {})
        pairs = [item for name, parameter in names.items() for item in (name, parameters[parameter])]
        if pairs:
            material.setproperties(*pairs)
    for phase in g_i.Phases[:]:
        phase.ShouldCalculate = True
    g_i.calculate()
    return [
        f"{phase.Identification.value}: {phase.LogInfo.value}"
        for phase in g_i.Phases[:]
        if int(phase.CalculationResult.value) != 1  # 0: not calculated, 1: ok, 2: failed
    ]


def read(g_o: Any) -> list[list[float]]:
    """Return time and vertical displacement of each point at all steps of the phases."""
    rows = []
    nodes = g_o.CurvePoints.Nodes[:]
    for phase in g_o.Phases[:]:
        if phase.Identification.value not in PHASES:
            continue
        for step in phase.Steps[:]:
            moved = [float(g_o.getcurveresults(node, step, g_o.ResultTypes.Soil.Uy)) for node in nodes[: len(POINTS)]]
            rows.append([float(step.Reached.Time.value), *moved])
    return rows


def main(slot: int) -> int:
    """Run once."""
    parameters = json.loads(Path("parameters.json").read_text(encoding="utf-8"))
    port, password = FIRST_PORT + 2 * slot, os.environ["PLAXIS_PASSWORD"]
    try:
        process = start(port, password)
    except NoAnswerError as error:
        print(error)
        return 4
    s_i, g_i = new_server("localhost", port, password=password)
    try:
        s_i.open(str(Path(PROJECT).resolve()))
        failed = calculate(g_i, parameters)
        if failed:
            print("FAILED PHASE", *failed, sep="\n")
            return 3
        g_i.view(g_i.Phases[-1])  # starts Output, whose server listens on the next port
        _, g_o = new_server("localhost", port + 1, password=password)
        rows = read(g_o)
    finally:
        g_i.kill()
        process.wait(60)
    lines = [",".join(["time", *(f"uy_{point}" for point in POINTS)]), *(",".join(map(repr, row)) for row in rows)]
    Path("results.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    print("FINISHED")
    return 0


if __name__ == "__main__":
    sys.exit(main(int(sys.argv[1])))
