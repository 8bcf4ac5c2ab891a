"""Objects that ask a server in JSON, a line each way."""

from __future__ import annotations

import json
import socket
from types import SimpleNamespace
from typing import Any


class Connection:
    def __init__(self, address: str, port: int, password: str) -> None:
        self._where, self._password = (address, port), password

    def ask(self, command: str, *arguments: Any) -> Any:
        with socket.create_connection(self._where, 5.0) as link, link.makefile("rw") as lines:
            lines.write(json.dumps({"password": self._password, "command": command, "arguments": arguments}) + "\n")
            lines.flush()
            answer = json.loads(lines.readline())
        if "error" in answer:
            raise RuntimeError(answer["error"])
        return answer["value"]


def value(of: Any) -> SimpleNamespace:
    return SimpleNamespace(value=of)


class Input:
    """The global object of Input."""

    def __init__(self, link: Connection) -> None:
        self._link = link

    @property
    def Materials(self) -> list[Any]:
        def material(name: str) -> SimpleNamespace:
            def setproperties(*pairs: Any) -> None:
                self._link.ask("setproperties", name, *pairs)

            return SimpleNamespace(Name=value(name), setproperties=setproperties)

        return [material(name) for name in self._link.ask("materials")]

    @property
    def Phases(self) -> list[Any]:
        return [
            SimpleNamespace(Identification=value(name), CalculationResult=value(result), LogInfo=value(log))
            for name, result, log in self._link.ask("phases")
        ]

    def calculate(self) -> str:
        return str(self._link.ask("calculate"))

    def view(self, phase: Any) -> int:
        return int(self._link.ask("view", phase.Identification.value))

    def kill(self) -> None:
        self._link.ask("kill")


class Output:
    """The global object of Output."""

    ResultTypes = SimpleNamespace(Soil=SimpleNamespace(Uy="Soil.Uy"))

    def __init__(self, link: Connection) -> None:
        self._link = link

    @property
    def CurvePoints(self) -> SimpleNamespace:
        return SimpleNamespace(Nodes=self._link.ask("nodes"))

    @property
    def Phases(self) -> list[Any]:
        def step(time: float) -> SimpleNamespace:
            return SimpleNamespace(Reached=SimpleNamespace(Time=value(time)))

        return [
            SimpleNamespace(Identification=value(name), Steps=[step(time) for time in times])
            for name, times in self._link.ask("steps")
        ]

    def getcurveresults(self, node: str, step: Any, kind: str) -> float:
        return float(self._link.ask("getcurveresults", node, step.Reached.Time.value, kind))


def new_server(address: str, port: int, timeout: float = 5.0, password: str = "") -> tuple[Any, Any]:
    """Connect; return the server and its global object."""
    del timeout
    link = Connection(address, port, password)
    if link.ask("name") == "output":
        return SimpleNamespace(), Output(link)
    return SimpleNamespace(open=lambda path: link.ask("open", path)), Input(link)
