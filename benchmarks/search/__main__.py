"""Run the suite: ``python -m benchmarks.search --seeds 30 --output docs/search``; needs the extra ``bench``."""

from __future__ import annotations

import json
import warnings
from pathlib import Path

import click
import numpy as np
from threadpoolctl import threadpool_limits

from benchmarks.search.methods import LIMIT, METHODS, Outcome
from benchmarks.search.problems import PROBLEMS
from benchmarks.search.unseen import UNSEEN

FIRST_SEED = 47_000  # none of these was used while the method was made


@click.command()
@click.option("--seeds", default=30, show_default=True, help="runs of each method on each problem")
@click.option("--method", "methods", multiple=True, type=click.Choice(list(METHODS)), help="only these methods")
@click.option("--unseen", is_flag=True, help="the twenty curves that the method was not made with")
@click.option("--problem", "problems", multiple=True, type=click.Choice([*PROBLEMS, *UNSEEN]), help="only these")
@click.option("--results", type=click.Path(path_type=Path), default="search-results.json", help="kept between runs")
def main(seeds: int, methods: tuple[str, ...], unseen: bool, problems: tuple[str, ...], results: Path) -> None:
    """Measure evaluations to target; what is in the results file already is not run again."""
    warnings.simplefilter("ignore")
    known: dict[str, list[list[float]]] = json.loads(results.read_text()) if results.exists() else {}
    for problem in problems or (UNSEEN if unseen else PROBLEMS):
        task = (PROBLEMS | UNSEEN)[problem]()
        for method in methods or METHODS:
            key = f"{problem}|{method}"
            if len(known.get(key, ())) >= seeds:
                continue
            with threadpool_limits(limits=1):
                outcomes = [METHODS[method](task, FIRST_SEED + seed) for seed in range(seeds)]
            known[key] = [[o.solved, o.evaluations, o.generations, o.overhead] for o in outcomes]
            lines = (f"{json.dumps(name)}: {json.dumps(runs)}" for name, runs in known.items())
            results.write_text("{\n" + ",\n".join(lines) + "\n}\n")
            print(f"{problem:20s} {method:15s} {summary(outcomes)}", flush=True)


def summary(outcomes: list[Outcome]) -> str:
    """Median and 90th percentile of evaluations and generations; unsolved runs count as never."""
    evaluations = [o.evaluations if o.solved else np.inf for o in outcomes]
    generations = [o.generations if o.solved else np.inf for o in outcomes]
    numbers = [np.percentile(v, q, method="higher") for v in (evaluations, generations) for q in (50, 90)]
    shown = [f"{n:6.0f}" if np.isfinite(n) else f">{LIMIT:5d}" for n in numbers]
    solved = np.mean([o.solved for o in outcomes])
    return f"{' '.join(shown)}  {100 * solved:3.0f} %  {1e3 * np.median([o.overhead for o in outcomes]):5.1f} ms"


if __name__ == "__main__":
    main()
