"""Problem files bent in every way: what is wrong is told as issues, never as a traceback."""

from __future__ import annotations

import copy
import json
import math
import random
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import pytest
from ruamel.yaml import YAML

from geoswarm.solver.calibration import Calibration
from geoswarm.solver.course import Course
from geoswarm.solver.errors import InfeasibleSpaceError, Issue, ProblemError
from geoswarm.solver.problem import Problem, parse_problem, read_document

ROOT = Path(__file__).parents[3]
FEW, MANY = 300, 10_000

SEEDS: list[dict[str, Any]] = [
    {
        "name": "line",
        "forward_model": {"kind": "formula", "series": {"y": {"expression": "a + b * x"}}},
        "parameters": {
            "a": {"lower": 1e-3, "upper": 5, "scale": "log", "initial": 1.0},
            "b": {"expression": "2 * a"},
            "c": {"value": 3.0},
        },
        "constraints": ["a < 4", "b > 0 and a > 0"],
        "observations": [
            {
                "series": "y",
                "points": {"x": [0, 1, 2], "y": [1, 3, 5], "weight": [1, 1, 2]},
                "x_unit": "min",
                "y_unit": "mm",
            }
        ],
        "method": {"kind": "particle_swarm", "particles": 6},
        "stopping": {"max_evaluations": 60, "target_objective": 1e-9},
        "seed": 7,
    },
    {
        "name": "oedometer",
        "forward_model": {
            "kind": "oedometer",
            "material": "soft_soil_creep",
            "height": 0.02,
            "initial_stress": 0.2,
            "stages": [{"stress": 9, "duration": 2}, {"stress": 13, "duration": 1}],
        },
        "parameters": {
            "lambda_star": {"lower": 0.002, "upper": 1.0, "scale": "log"},
            "kappa_star": {"lower": 0.001, "upper": 0.5, "scale": "log"},
            "mu_star": {"value": 1.46e-3},
            "c": {"value": 5},
            "phi": {"value": 20},
            "psi": {"value": 0},
        },
        "constraints": ["lambda_star > kappa_star"],
        "observations": [{"series": "settlement", "points": {"x": [0.1, 1, 2], "y": [0.1, 0.2, 0.3]}, "y_unit": "mm"}],
        "method": {"kind": "monte_carlo", "samples": 100, "sampling": "sobol"},
    },
    {
        "name": "both",
        "forward_model": {
            "kind": "combined",
            "parts": {
                "one": {"kind": "formula", "series": {"y": "a * x"}},
                "two": {
                    "kind": "isotropic_compression",
                    "height": 0.1,
                    "diameter": 0.05,
                    "initial_stress": 10,
                    "stages": [{"stress": 50, "duration": 1}],
                },
            },
        },
        "parameters": {
            "one.a": {"lower": 0, "upper": 1},
            "two.lambda_star": {"lower": 0.01, "upper": 0.2},
            "two.kappa_star": {"value": 0.005},
            "two.mu_star": {"value": 0.001},
            "two.c": {"value": 5},
            "two.phi": {"value": 25},
            "two.psi": {"value": 0},
        },
        "observations": [
            {"series": "one.y", "points": {"x": [0, 1], "y": [0, 1]}},
            {"series": "two.volumetric_strain", "points": {"x": [0.5, 1], "y": [0.01, 0.02]}},
        ],
        "method": {"kind": "particle_swarm", "particles": 4, "topology": "ring", "form": "inertia_weight"},
        "stopping": {"stagnation_generations": 3},
    },
]

ODD: list[Any] = [
    *(None, True, False, 0, -1, 1, 2**31, 2**63, -(2**70), 10**400, 1e308, -1e308, 5e-324, 1e-300, math.inf, -math.inf),
    *(
        math.nan,
        0.1,
        "",
        " ",
        "x",
        "\0",
        "\ud800",
        "a" * 5000,
        "é" * 50,
        "1e999",
        "0x10",
        "nan",
        "inf",
        "__import__",
        "lambda",
    ),
    *("a + ", "((((a", "a ** 10 ** 10 ** 10", "1 / 0", "a.b.c", "x; y", "a if b else c", "9" * 500, "-" * 900 + "a"),
    *(
        "formula",
        "oedometer",
        "combined",
        "particle_swarm",
        "sobol",
        "log",
        "m",
        "kPa",
        "furlong/fortnight",
        "degC",
        "/",
    ),
    *(
        [],
        {},
        [[]],
        [None],
        [{}],
        {"": ""},
        {"a": {}},
        [1, "a", None],
        [[1, 2], [3]],
        {"file": "/etc/passwd"},
        list(range(200)),
    ),
]


PIECES = (
    *("", "{", "}", "[", "]", ":", "- ", "\n", "\t", "&a ", "*a", "!!python/object:os.system ", "|", '"', "'", "\0"),
    *("%", "@", "<<: ", "? ", "---\n", "😀"),
)


def places(value: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """Every place in a document."""
    found = [path] if path else []
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, inner in items:
        found += places(inner, (*path, key))
    return found


def at(document: Any, path: tuple[Any, ...]) -> Any:
    for key in path:
        document = document[key]
    return document


def bend(document: dict[str, Any], rng: random.Random) -> None:
    """Change a document at one place."""
    spots = places(document)
    if not spots:
        return
    *parents, key = rng.choice(spots)
    holder = at(document, tuple(parents))
    kind = rng.randrange(8)
    if kind == 0:
        del holder[key]
    elif kind == 1 and isinstance(holder, dict):
        holder[str(rng.choice(ODD))[:200]] = holder.pop(key)
    elif kind == 2:
        holder[key] = copy.deepcopy(at(document, rng.choice(spots)))
    elif kind == 3 and isinstance(holder[key], int | float) and abs(holder[key]) < 1e300:
        holder[key] = holder[key] * rng.choice((-1, 0, 1e-12, 1e3, 1e12, 1e300))
    elif kind == 4 and isinstance(holder[key], str) and holder[key]:
        cut = rng.randrange(len(holder[key]))
        holder[key] = holder[key][:cut] + rng.choice("()+-*/.,<>= \n\t\0é😀") + holder[key][cut:]
    elif kind == 5 and isinstance(holder[key], list):
        holder[key] = holder[key] * rng.choice((0, 2, 50))
    else:
        holder[key] = copy.deepcopy(rng.choice(ODD))


def corrupt(text: str, rng: random.Random) -> str:
    """Damage the text of a file."""
    for _ in range(rng.randrange(1, 6)):
        start = rng.randrange(len(text) + 1)
        end = min(len(text), start + rng.randrange(12))
        middle = rng.choice((*PIECES, text[start:end] * 3))
        text = text[:start] + middle + text[end:]
    return text


def to_yaml(document: dict[str, Any]) -> str:
    import io

    stream = io.StringIO()
    YAML(typ="safe", pure=True).dump(document, stream)
    return stream.getvalue()


def files(count: int) -> Iterator[tuple[int, Any, str]]:
    """Generate texts of problem files with their form, the same in every run."""
    for number in range(count):
        rng = random.Random(number)
        document = copy.deepcopy(rng.choice(SEEDS))
        for _ in range(rng.choice((0, 1, 1, 1, 2, 3, 8))):
            bend(document, rng)
        form = rng.choice(("json", "json", "yaml"))
        try:
            text = to_yaml(document) if form == "yaml" else json.dumps(document)
        except (ValueError, UnicodeEncodeError):  # a number of thousands of digits, half a character
            text = repr(document)
        yield number, form, corrupt(text, rng) if rng.random() < 0.4 else text


def issues_of(text: str, form: Any) -> tuple[Problem | None, Sequence[Issue]]:
    """Read a problem; return it, or its issues."""
    try:
        return parse_problem(read_document(text, form)), ()
    except ProblemError as error:
        return None, error.issues


def can_start(problem: Problem) -> bool:
    """Whether the search finds points to begin with."""
    try:
        Course(Calibration(problem, 1)).start()
    except InfeasibleSpaceError:
        return False
    return True


def check_corpus(count: int) -> tuple[int, int]:
    """Read every file; return how many were accepted and how many refused."""
    accepted = refused = 0
    for number, form, text in files(count):
        problem, issues = issues_of(text, form)
        if problem is None:
            refused += 1
            assert issues, number
            for issue in issues:
                assert issue.message, number
                assert "Traceback" not in issue.message, number
                assert len(str(issue)) < 2000, (number, str(issue)[:300])
        else:
            accepted += 1
            assert parse_problem(problem.document()).document() == problem.document(), number
            assert can_start(problem) in (True, False), number
    return accepted, refused


def test_a_bent_problem_file_is_refused_with_issues_or_works() -> None:
    accepted, refused = check_corpus(FEW)
    assert accepted >= 15
    assert refused >= 100


@pytest.mark.slow
@pytest.mark.timeout(1800)
def test_ten_thousand_bent_problem_files() -> None:
    accepted, refused = check_corpus(MANY)
    assert accepted + refused == MANY
    assert accepted >= 500
    assert refused >= 5000


def test_the_command_line_tells_them_without_a_traceback(tmp_path: Path) -> None:
    from geoswarm.cli import main

    for _number, form, text in list(files(60)):
        path = tmp_path / f"problem.{form}"
        path.write_bytes(text.encode("utf-8", "surrogatepass"))
        assert main(["evaluate", str(path)]) in (0, 1, 2)
