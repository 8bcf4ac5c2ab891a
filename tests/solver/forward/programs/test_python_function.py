"""A Python function of a file as a forward model."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from textwrap import dedent
from typing import Any

import numpy as np
import pytest

from geoswarm.solver.calibration import Calibration, Evaluation
from geoswarm.solver.errors import ProblemError
from geoswarm.solver.external.python.signature import SignatureError, signature_in, signature_of
from geoswarm.solver.forward.registry import offered_kinds
from geoswarm.solver.problem import Problem, load_problem, parse_problem, problem_schema
from geoswarm.solver.runs.local import calibrate
from tests.api.conftest import line_problem

SERIES = {"y": {}}


def written(folder: Path, source: str, **more: Any) -> Path:
    """A problem with a function f of a, and its file."""
    (folder / "model.py").write_text(dedent(source))
    document: dict[str, Any] = {
        "forward_model": {"kind": "python", "file": "model.py", "function": "f", "series": SERIES},
        "parameters": {"a": {"lower": 0.0, "upper": 10.0}},
        "observations": [{"series": "y", "points": {"x": [1, 2, 4], "y": [3, 6, 12]}}],
        "method": {"kind": "particle_swarm", "particles": 5},
        "stopping": {"max_evaluations": 20},
        "seed": 3,
    }
    path = folder / "problem.json"
    path.write_text(json.dumps(document | more))
    return path


def loaded(folder: Path, source: str, **more: Any) -> Problem:
    return load_problem(written(folder, source, **more))


def evaluated(folder: Path, source: str, values: Mapping[str, float] | None = None, **more: Any) -> Evaluation:
    return Calibration(loaded(folder, source, **more), 1).evaluate_values(values or {"a": 3.0})


@pytest.mark.parametrize(
    ("source", "parameters", "points", "is_open"),
    [
        ("def f(E, nu=0.3): ...", {"E": None, "nu": 0.3}, False, False),
        ("def f(x, E, *, k=-2): ...", {"E": None, "k": -2.0}, True, False),
        ("def f(a, **rest): ...", {"a": None}, False, True),
        ("def f(a, name='clay', flag=True, x=None, b=1e400): ...", {"a": None}, True, False),
        ("@cache\ndef f(a): ...", {"a": None}, False, False),
        ("try:\n  import q\nexcept ImportError:\n  def f(b): ...", {"b": None}, False, False),
        ("def f(a): ...\ndef f(b): ...", {"b": None}, False, False),
    ],
)
def test_arguments_are_read_from_the_source(
    source: str, parameters: dict[str, float | None], points: bool, is_open: bool
) -> None:
    found = signature_in(source.encode(), "model.py", "f")
    assert (found.parameters, found.points, found.open) == (parameters, points, is_open)


@pytest.mark.parametrize(
    ("source", "message"),
    [
        ("def g(): ...\ndef _h(): ...", "model.py has no function f; it has g$"),
        ("", "it has none"),
        ("def f(", r"model.py, line 1 is not valid Python: '\(' was never closed"),
        ("\0", "model.py.* not valid Python"),
        ("def f(a, /): ...", "takes a by position only"),
        ("def f(*a): ...", "takes \\*arguments without names"),
        ("async def f(a): ...", "f of model.py is async"),
        ("class f: ...", "line 1 makes it a class; a function that is written there as def f"),
        ("from m import g as f", "line 1 imports it from elsewhere"),
        ("def f(a): ...\nf = cache(f)", "line 2 assigns it"),
        ("(" * 5000, "not valid Python"),
    ],
)
def test_what_cannot_be_given_is_reported(source: str, message: str) -> None:
    with pytest.raises(SignatureError, match=message):
        signature_in(source.encode(), "model.py", "f")


def test_a_function_at_hand_says_the_same_as_its_source() -> None:
    def f(x, E, nu=0.3, *, name="clay", **rest):  # type: ignore[no-untyped-def]
        return x, E, nu, name, rest

    source = b"def f(x, E, nu=0.3, *, name='clay', **rest): ..."
    assert signature_of(f, "f") == signature_in(source, "model.py", "f")
    with pytest.raises(SignatureError, match="update does not say which arguments"):
        signature_of(dict.update, "update")


def test_nothing_is_executed_before_a_calculation_is_made(tmp_path: Path) -> None:
    problem = loaded(tmp_path, f"import os\nos.mkdir({str(tmp_path / 'trace')!r})\ndef f(x, a): return a * x")
    calibration = Calibration(problem, 1)
    assert not (tmp_path / "trace").exists()
    assert calibration.evaluate_values({"a": 3.0}).objective == 0.0
    assert (tmp_path / "trace").exists()


def test_a_calibration_by_workers_is_that_of_this_process(tmp_path: Path) -> None:
    problem = loaded(tmp_path, "from helper import twice\ndef f(x, a): return twice(a * x) / 2")
    (tmp_path / "helper.py").write_text("def twice(y): return 2 * y")
    here = Calibration(problem, 1)
    history = [record.evaluation for record in calibrate(problem, workers=2).history]
    assert [one.objective for one in history] == [here.evaluate(one.parameters).objective for one in history]
    assert not any(one.reason for one in history)


def test_the_document_gives_the_same_problem_and_names_the_version(tmp_path: Path) -> None:
    problem = loaded(tmp_path, "def f(x, a, b=1): return a * x")
    section = problem.document()["forward_model"]
    assert section["folder"] == str(tmp_path)
    assert len(section["version"]) == 64
    assert parse_problem(problem.document(), programs=True) == problem
    other = loaded(tmp_path, "def f(x, a, b=1): return a * x  # changed")
    assert other.document()["forward_model"]["version"] != section["version"]
    assert "has changed since" in (Calibration(problem, 1).evaluate_values({"a": 1.0}).message or "")


def test_units_are_those_of_the_function_and_few_digits_stay(tmp_path: Path) -> None:
    source = "def f(x, a):\n    assert list(x) == [0.1, 10, 1440]\n    return [1000 * a] * 3"
    series = {"y": {"x_unit": "min", "y_unit": "mm"}}
    points = {"x": [0.1, 10, 1440], "y": [3, 3, 3]}
    observation = {"series": "y", "points": points, "x_unit": "min", "y_unit": "m"}
    model = {"kind": "python", "file": "model.py", "function": "f", "series": series}
    found = evaluated(tmp_path, source, forward_model=model, observations=[observation])
    assert found.message is None
    assert found.responses["y"].tolist() == [3.0, 3.0, 3.0]


@pytest.mark.parametrize(
    ("returned", "expected"),
    [
        ("a * x", [3, 6, 12]),
        ("{'y': [3, 6, 12], 'other': None}", [3, 6, 12]),
        ("{'y': ([4, 0], [12, 0])}", [3, 6, 12]),
    ],
)
def test_what_is_accepted(tmp_path: Path, returned: str, expected: list[float]) -> None:
    found = evaluated(tmp_path, f"def f(x, a): return {returned}")
    assert found.responses["y"].tolist() == expected


@pytest.mark.parametrize(
    ("returned", "message"),
    [
        ("None", r"f returned None \(is a return missing\?\); accepted: an array of real numbers"),
        ("3.0", r"the single value 3.0; accepted: an array of shape \(3,\), one value for each observed point"),
        ("[1, 2]", "a list of 2; accepted"),
        ("np.ones((3, 1))", r"an array of shape \(3, 1\); accepted"),
        ("(x, x)", "a tuple of 2; accepted: an array of shape"),
        ("['a', 'b', 'c']", "accepted: an array of real numbers"),
        ("np.ones(3) * 1j", "type complex128; accepted: an array of real"),
        ("[[1, 2], [3]]", "accepted: an array of real numbers"),
        ("{}", "no series 'y'; it returned an empty dict"),
        ("{'Y': x}", "no series 'y'; it returned Y"),
        ("{'y': (x, x, x)}", "a tuple of 3 for 'y'; accepted: an array, or a tuple"),
        ("{'y': (x, x[:2])}", r"x of shape \(3,\) and y of shape \(2,\)"),
        ("{'y': ([1, np.nan], [1, 2])}", "x of 'y' that is not finite"),
        ("{'y': ([1, 2], [1, 2])}", "y was calculated for x from 1 to 2"),
        ("object()", "returned a object|an object"),
    ],
)
def test_anything_else_is_bad_output_in_words(tmp_path: Path, returned: str, message: str) -> None:
    found = evaluated(tmp_path, f"import numpy as np\ndef f(x, a): return {returned}")
    assert found.reason == "bad_output"
    with pytest.raises(AssertionError, match=message):
        raise AssertionError(found.message)


def test_values_that_are_not_finite_have_their_own_reason(tmp_path: Path) -> None:
    assert evaluated(tmp_path, "def f(x, a): return x * float('nan')").reason == "not_finite"


def test_several_series_get_x_by_name(tmp_path: Path) -> None:
    source = "def f(x, a): return {'u': a * x['u'], 'v': x['v']}"
    points = [{"series": n, "points": {"x": x, "y": x}} for n, x in (("u", [1, 2]), ("v", [5, 4, 6]))]
    model = {"kind": "python", "file": "model.py", "function": "f", "series": {"u": {}, "v": {}}}
    found = evaluated(tmp_path, source, {"a": 1.0}, forward_model=model, observations=points)
    assert found.objective == 0.0
    only = evaluated(tmp_path, "def f(a): return [1, 2]", forward_model=model, observations=points)
    assert "with the series u, v a dict is accepted" in (only.message or "")


def test_an_exception_is_told_with_the_lines_of_the_users_file_alone(tmp_path: Path) -> None:
    source = """
        import numpy as np
        def inner(a):
            return np.linalg.solve(np.zeros((2, 2)), np.ones(2))
        def f(x, a):
            return inner(a)
        """
    found = evaluated(tmp_path, source)
    lines = (found.message or "").splitlines()
    assert found.reason == "bad_output"
    assert lines == [
        "f raised LinAlgError: Singular matrix",
        "  model.py, line 6, in f: return inner(a)",
        "  model.py, line 4, in inner: return np.linalg.solve(np.zeros((2, 2)), np.ones(2))",
    ]


@pytest.mark.parametrize(
    ("statement", "reason", "message"),
    [
        (
            "import geoswarm\n    raise geoswarm.DivergedError('no equilibrium')",
            "diverged",
            "no equilibrium\n  model.py",
        ),
        ("import sys\n    sys.exit(3)", "bad_output", "f ended the program"),
        ("raise MemoryError", "killed_memory", "ran out of memory"),
        ("return data", "bad_output", "below if __name__ == '__main__' does not run"),
        ("f(x, a)", "bad_output", "RecursionError"),
    ],
)
def test_reasons_of_failures(tmp_path: Path, statement: str, reason: str, message: str) -> None:
    found = evaluated(tmp_path, f"def f(x, a):\n    {statement}")
    assert found.reason == reason
    assert message in (found.message or "")


@pytest.mark.parametrize(
    ("source", "message"),
    [
        ("import no_such_module\n", "model.py cannot be imported: it raised ModuleNotFoundError"),
        ("raise SystemExit(1)\n", "ended the program"),
        ("import json\n", "imports json, and .*json.py is in the same folder; but that name is taken by"),
    ],
)
def test_a_file_that_cannot_be_imported(tmp_path: Path, source: str, message: str) -> None:
    (tmp_path / "json.py").write_text("")
    found = evaluated(tmp_path, source + "def f(x, a): return x")
    assert found.reason == "bad_output"
    with pytest.raises(AssertionError, match=message):
        raise AssertionError(found.message)


@pytest.mark.parametrize(
    ("section", "path", "message"),
    [
        ({"file": None}, "forward_model.file", "is missing"),
        ({"file": "other.py"}, "forward_model.file", "is not there"),
        ({"file": "sub.py"}, "forward_model.file", "is not a file"),
        ({"file": "/etc/passwd.py"}, "forward_model.file", "relative name of a .py file"),
        ({"file": "../model.py"}, "forward_model.file", "relative name"),
        ({"file": "model.txt"}, "forward_model.file", "relative name"),
        ({"function": "g"}, "forward_model.function", "model.py has no function g; it has f"),
        ({"function": "import os"}, "forward_model.function", "is not the name of a function"),
        ({"function": "class"}, "forward_model.function", "is not the name of a function"),
        ({"series": {}}, "forward_model.series", ""),
        ({"series": {"y": {"x_unit": "furlongy"}}}, "forward_model.series.y.x_unit", "unknown unit"),
    ],
)
def test_mistakes_in_the_section_have_their_path(
    tmp_path: Path, section: dict[str, Any], path: str, message: str
) -> None:
    (tmp_path / "sub.py").mkdir()
    model = {"kind": "python", "file": "model.py", "function": "f", "series": SERIES} | section
    with pytest.raises(ProblemError) as caught:
        loaded(tmp_path, "def f(x, a): return x", forward_model=model)
    assert [issue.path for issue in caught.value.issues] == [path]
    assert message in caught.value.issues[0].message


def test_unknown_and_missing_parameters_are_told_with_the_arguments(tmp_path: Path) -> None:
    with pytest.raises(ProblemError, match=r"parameters.a: unknown parameter .* known: E, nu") as caught:
        loaded(tmp_path, "def f(E, nu=0.3): ...")
    assert "parameters.E: is missing (Argument of f); give bounds" in str(caught.value)
    assert "parameters: if f needs the observed points, name their argument x" in str(caught.value)


def test_open_functions_get_every_parameter(tmp_path: Path) -> None:
    parameters = {"a": {"lower": 0, "upper": 9}, "b": {"value": 2}, "c": {"expression": "a * b"}}
    found = evaluated(
        tmp_path, "def f(x, **p): return p['c'] / p['b'] * x", {"a": 3, "b": 2, "c": 6}, parameters=parameters
    )
    assert found.objective == 0.0


def test_it_is_refused_over_the_network(tmp_path: Path) -> None:
    document = loaded(tmp_path, "def f(x, a): return x").document()
    with pytest.raises(ProblemError, match="accepted from problem files and Python only"):
        parse_problem(document)
    inside = {**document, "forward_model": {"kind": "combined", "parts": {"p": document["forward_model"]}}}
    with pytest.raises(ProblemError, match="accepted from problem files"):
        parse_problem(inside)
    bare = {**document, "forward_model": {"kind": "python", "file": "m.py", "function": "f", "series": SERIES}}
    with pytest.raises(ProblemError, match=r"forward_model.file: kind: python names a file"):
        parse_problem(bare, programs=True)


def test_it_is_not_offered() -> None:
    assert "python" not in offered_kinds()
    assert "forward_model_python" not in problem_schema()["$defs"]
    assert "forward_model_python" in problem_schema(programs=True)["$defs"]
    assert line_problem()["forward_model"]["kind"] in offered_kinds()


def test_a_file_of_a_package_is_imported_as_its_module(tmp_path: Path) -> None:
    package = tmp_path / "soil_of_tests"
    package.mkdir()
    (package / "__init__.py").write_text("")
    (package / "factors.py").write_text("ONE = 1.0")
    (package / "curve.py").write_text("from .factors import ONE\ndef f(x, a): return ONE * a * x")
    model = {"kind": "python", "file": "soil_of_tests/curve.py", "function": "f", "series": SERIES}
    found = evaluated(tmp_path, "", forward_model=model)
    assert found.message is None
    assert found.objective == 0.0
    np.testing.assert_array_equal(found.responses["y"], [3.0, 6.0, 12.0])
