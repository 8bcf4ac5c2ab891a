"""A program that calculates y = slope * x, and misbehaves as its first argument says where the slope is positive.

It reads ``input.txt`` and writes ``out.csv``, as a program of an engineer's would. Run by the tests.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path


def write(slope: float, points: int = 5, path: str = "out.csv") -> None:
    lines = ["x,y", *(f"{x},{slope * x!r}" for x in range(points))]
    Path(path).write_text("\n".join(lines) + "\n")


def misbehave(behaviour: str, slope: float) -> None:
    match behaviour:
        case "exit_1":
            sys.stdout.write("*ERROR: no convergence in increment 7\n")
            sys.exit(1)
        case "exit_3":
            sys.exit(3)
        case "error_text":
            Path("job.log").write_text("step 1\n *ERROR: zero pivot\n")
            write(slope)
        case "killed":
            os.kill(os.getpid(), signal.SIGKILL)
        case "no_output" | "old_output":
            return
        case "truncated":
            write(slope)
            text = Path("out.csv").read_text()
            Path("out.csv").write_text(text[: text.rindex(",")])
        case "not_finite":
            write(float("nan"))
        case "too_few":
            write(slope, points=2)
        case "encoding":
            Path("out.csv").write_bytes("x,y,µ\n0,0,0\n1,1,0\n".encode("latin-1"))
        case "disk_full":
            write(slope, path="/dev/full")
        case "loud":
            block = b"a line of output that nobody reads\n" * 30_000
            for _ in range(1 + 1_000_000_000 // len(block)):
                os.write(1, block)
            write(slope)
        case "children":
            for session in (False, True):
                subprocess.Popen(["sleep", "600"], start_new_session=session)
            write(slope)
        case "hangs":
            time.sleep(600)
        case "licence":
            tries = Path(os.environ["ZOO_TRIES"])
            count = len(tries.read_text()) if tries.exists() else 0
            tries.write_text("x" * (count + 1))
            if count < 2:
                sys.exit(4)
            write(slope)
        case _:
            raise SystemExit(f"unknown behaviour {behaviour}")


def main() -> None:
    behaviour, slope = sys.argv[1], float(Path("input.txt").read_text())
    sys.stdout.write(f"slope {slope}\n")
    if slope > 0.0 and behaviour != "good":
        misbehave(behaviour, slope)
    else:
        write(slope)


if __name__ == "__main__":
    main()
