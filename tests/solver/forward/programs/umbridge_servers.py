"""A server of UM-Bridge that answers as a test says."""

from __future__ import annotations

import json
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

__all__ = ["CUT_OFF", "HANG", "HANG_UP", "Scripted", "scripted"]

HANG, HANG_UP, CUT_OFF = "hang", "hang up", "cut off"


@dataclass
class Scripted:
    """Answers by route: an object, a text, (status, text), HANG, HANG_UP, CUT_OFF; a list: one after the other."""

    answers: dict[str, Any]
    url: str = ""
    asked: list[tuple[str, Any]] = field(default_factory=list)
    over: threading.Event = field(default_factory=threading.Event)


GOOD: dict[str, Any] = {
    "/Info": {"protocolVersion": 1.0, "models": ["forward", "other"]},
    "/ModelInfo": {"support": {"Evaluate": True}},
    "/InputSizes": {"inputSizes": [1, 1]},
    "/OutputSizes": {"outputSizes": [2, 3]},
    "/Evaluate": {"output": [[7, 8], [1000.0, 2000.0, 4000.0]]},
}


@contextmanager
def scripted(**answers: Any) -> Iterator[Scripted]:
    """Serve good answers, but for some routes (without /) those that are given."""
    script = Scripted(GOOD | {f"/{route}": answer for route, answer in answers.items()})

    class Handler(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            self._answer(None)

        def do_POST(self) -> None:
            self._answer(json.loads(self.rfile.read(int(self.headers["Content-Length"]))))

        def _answer(self, body: Any) -> None:
            script.asked.append((self.path, body))
            answer = script.answers[self.path]
            if isinstance(answer, list):
                answer = answer.pop(0) if len(answer) > 1 else answer[0]
            if answer == HANG:
                script.over.wait(20.0)
            if answer in (HANG, HANG_UP):
                self.connection.close()
                return
            status, text = answer if isinstance(answer, tuple) else (200, answer)
            if answer == CUT_OFF:  # what came so far would be an answer
                text = {"output": [[7, 8], [1.0, 2.0, 3.0]]}
            data = (text if isinstance(text, str) else json.dumps(text)).encode()
            self.send_response(status)
            self.send_header("Content-Length", str(len(data) + 5 * (answer == CUT_OFF)))
            self.end_headers()
            self.wfile.write(data)

        def log_message(self, format: str, *args: Any) -> None:
            """Say nothing."""

    class Server(ThreadingHTTPServer):
        daemon_threads = True

        def handle_error(self, request: Any, client_address: Any) -> None:
            """Say nothing: a test hangs up."""

    with Server(("127.0.0.1", 0), Handler) as server:
        script.url = f"http://127.0.0.1:{server.server_address[1]}"
        thread = threading.Thread(target=server.serve_forever, args=(0.01,))
        thread.start()
        try:
            yield script
        finally:
            script.over.set()
            time.sleep(0.01)
            server.shutdown()
            thread.join()
