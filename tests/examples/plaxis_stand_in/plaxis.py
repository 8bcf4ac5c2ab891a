"""Stand-in for PLAXIS: listens on two ports, checks the password, and calculates settlements by a formula.

Refuses to start without a licence (a file ``licence`` beside the log), and a project that is open elsewhere. Every
command is appended to the log that STAND_IN_LOG names in the project: a line of JSON.
"""

from __future__ import annotations

import json
import math
import os
import socketserver
import sys
import threading
from pathlib import Path
from typing import Any

OPTIONS = dict(argument.lstrip("-").split("=", 1) for argument in sys.argv[1:])
PORT, PASSWORD = int(OPTIONS["AppServerPort"]), OPTIONS["AppServerPassword"]
HERE = Path(__file__).resolve().parent
TIMES = [0.3, 1, 3, 10, 30, 100, 300, 1000, 3000]
STATE: dict[str, Any] = {"project": None, "clay": {}, "result": 0, "log": "", "output": False}


def answer(output: bool, command: str, arguments: list[Any]) -> Any:
    with (HERE / "log").open("a", encoding="utf-8") as log:
        log.write(json.dumps([PORT + output, command, arguments]) + "\n")
    if command == "name":
        return "output" if output else "input"
    if output:
        if not STATE["output"]:
            raise ValueError("Output is not open")
        return {"nodes": lambda: ["node 1", "node 2"], "steps": steps, "getcurveresults": result}[command](*arguments)
    return {
        "open": open_project,
        "materials": lambda: ["sand", "clay"],
        "phases": lambda: [["Initial", 1, "OK"], ["Consolidation", STATE["result"], STATE["log"]]],
        "setproperties": set_properties,
        "calculate": calculate,
        "view": view,
        "kill": lambda: None,
    }[command](*arguments)


def open_project(path: str) -> None:
    if not Path(path).is_file() or not Path(path + "dat").is_dir():
        raise ValueError(f"{path} is no project")
    STATE["project"] = path


def set_properties(material: str, *pairs: Any) -> None:
    if material != "clay":
        raise ValueError(f"{material} has no such property")
    STATE["clay"].update(zip(pairs[::2], pairs[1::2], strict=True))


def calculate() -> str:
    clay = STATE["clay"]
    if STATE["project"] is None or len(clay) < 3:
        raise ValueError("nothing to calculate")
    (Path(STATE["project"] + "dat") / "results").write_text(json.dumps(clay), encoding="utf-8")
    if clay["muModified"] > clay["lambdaModified"] / 5.0:
        STATE.update(result=2, log="soil body collapses [101]")
        return "failed"
    STATE.update(result=1, log="OK")
    return "OK"


def view(_: str) -> int:
    STATE["output"] = True
    return PORT + 1


def steps() -> list[Any]:
    return [["Initial", [0.0]], ["Consolidation", TIMES]]


def result(node: str, time: float, kind: str) -> float:
    if kind != "Soil.Uy":
        raise ValueError(kind)
    clay = json.loads((Path(STATE["project"] + "dat") / "results").read_text(encoding="utf-8"))
    primary, creep = {"node 1": (8.0, 12.0), "node 2": (3.0, 9.0)}[node]
    consolidated = 1.0 - math.exp(-time / 20.0)
    return -primary * clay["lambdaModified"] * 0.5 * consolidated - creep * clay["muModified"] * math.log1p(time)


class Handler(socketserver.StreamRequestHandler):
    def handle(self) -> None:
        line = self.rfile.readline()
        if not line:  # only looked whether it listens
            return
        asked = json.loads(line)
        try:
            if asked["password"] != PASSWORD:
                raise ValueError("wrong password")
            told = {"value": answer(self.server.server_address[1] != PORT, asked["command"], asked["arguments"])}
        except ValueError as error:
            told = {"error": str(error)}
        self.wfile.write(json.dumps(told).encode() + b"\n")
        self.wfile.flush()
        if asked["command"] == "kill":
            os._exit(0)


class Server(socketserver.ThreadingTCPServer):
    allow_reuse_address = True


if __name__ == "__main__":
    licence = HERE / "licence"
    if not licence.exists():
        licence.touch()  # free for the next one
        sys.exit(1)
    with Server(("localhost", PORT), Handler) as first, Server(("localhost", PORT + 1), Handler) as second:
        threading.Thread(target=second.serve_forever, daemon=True).start()
        first.serve_forever()
