"""Write the table and the performance profile: ``python -m benchmarks.search.report --results FILE --output docs``."""

from __future__ import annotations

import json
from pathlib import Path

import click
import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from benchmarks.search.methods import LIMIT, METHODS
from benchmarks.search.problems import PROBLEMS

LARGEST_RATIO = 100.0
MEASURED = (
    "geoswarm and DFO-LS on 28 November 2026 with the development version of 0.2.0 and seeds from 47000 on,\n"
    "the textbook swarm and the other libraries until 22 November 2026 with seeds from 7000 on"
)
"""When and with which version ``results.json`` was written; change it with that file."""


@click.command()
@click.option(
    "--results", type=click.Path(path_type=Path, exists=True), default=Path(__file__).with_name("results.json")
)
@click.option("--output", type=click.Path(path_type=Path), default="docs")
def main(results: Path, output: Path) -> None:
    """Write ``search-benchmark.md`` and ``search-profile.svg``."""
    known: dict[str, list[list[float]]] = json.loads(results.read_text())
    (output / "search-benchmark.md").write_text(table(known), encoding="utf-8")
    mpl.rcParams["svg.hashsalt"] = "geoswarm"
    profile(known).savefig(output / "search-profile.svg", metadata={"Date": None})


def table(known: dict[str, list[list[float]]]) -> str:
    """One row a problem and method."""
    lines = [
        "# Search benchmark",
        "",
        f"Forward runs and generations until the target is reached: median and 90th percentile, {LIMIT} runs at most,",
        "unsolved ones count as more than that. Ten particles a generation unless the method says how many run at",
        "once; `least_squares` and DFO-LS (restarted from random points) run one after the other.",
        "Own time is the processor time that a method itself takes, a generation.",
        f"Measured: {MEASURED}.",
        "Written by `python -m benchmarks.search.report`.",
        "",
        "| problem | method | seeds | runs, median | runs, 90 % | generations, median | 90 % | solved | own time, ms |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for problem in PROBLEMS:
        for method in METHODS:
            rows = known.get(f"{problem}|{method}")
            if rows:
                lines.append(f"| {problem} | {method} | {len(rows)} | {' | '.join(cells(np.array(rows)))} |")
    return "\n".join(lines) + "\n"


def cells(rows: np.ndarray) -> list[str]:
    """Numbers of a row; ``rows`` has the columns solved, evaluations, generations, overhead."""
    solved = rows[:, 0] == 1.0
    numbers = []
    for column in (1, 2):
        values = np.where(solved, rows[:, column], np.inf)
        numbers += [np.percentile(values, q, method="higher") for q in (50, 90)]
    shown = [f"{n:.0f}" if np.isfinite(n) else "never" for n in numbers]
    return [*shown, f"{100 * solved.mean():.0f} %", f"{1e3 * np.median(rows[:, 3]):.1f}"]


def profile(known: dict[str, list[list[float]]]) -> Figure:
    """Share of all runs that a method solves within a multiple of the best method's median (Dolan and More 2002)."""
    figure = Figure(figsize=(8.4, 4.2), layout="constrained")
    axes = figure.subplots()
    best = {}
    for problem in PROBLEMS:
        medians = [median(known[f"{problem}|{m}"]) for m in METHODS if f"{problem}|{m}" in known]
        best[problem] = min(medians, default=np.inf)
    for method in METHODS:
        measured = [p for p in PROBLEMS if f"{p}|{method}" in known]
        if len(measured) < len(PROBLEMS):  # an incomplete row would flatter or harm
            continue
        ratios = np.sort(
            np.concatenate(
                [
                    [row[1] / best[p] if row[0] else np.inf for row in known[f"{p}|{method}"]]
                    for p in measured
                    if np.isfinite(best[p])
                ]
            )
        )
        share = np.arange(1, len(ratios) + 1) / len(ratios)
        inside = ratios <= LARGEST_RATIO
        axes.step(ratios[inside], share[inside], where="post", label=method)
    axes.set(xscale="log", xlim=(0.3, LARGEST_RATIO), ylim=(0.0, 1.0))
    axes.set(xlabel="forward runs / median of the best method", ylabel="share of runs solved")
    figure.legend(loc="outside right upper", fontsize="small")
    axes.grid(visible=True, alpha=0.3)
    return figure


def median(rows: list[list[float]]) -> float:
    """Median evaluations, inf when half of the runs are not solved."""
    return float(np.percentile([row[1] if row[0] else np.inf for row in rows], 50, method="higher"))


if __name__ == "__main__":
    main()
