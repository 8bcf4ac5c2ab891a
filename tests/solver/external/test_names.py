"""Names of parameters in templates, and those of the problem."""

from __future__ import annotations

from pathlib import Path

import pytest

from geoswarm.solver.errors import ProblemError
from geoswarm.solver.problem import load_problem

SECTION = "{kind: command, run: [prog], templates: {a: a.tpl, b: b.in}, series: {y: {file: b, x: 1, y: 2}}}"
PROBLEM = """
forward_model: MODEL
parameters: {NAME: {lower: 0, upper: 1}}
observations: [{series: SERIES, points: {x: [0], y: [0]}}]
stopping: {max_evaluations: 10}
"""


def problem(folder: Path, name: str, pest: str, own: str, *, combined: bool) -> Path:
    (folder / "a.tpl").write_text(f"ptf %\n%{pest:^12}%\n")
    (folder / "b.in").write_text(f"{own}\n")
    model = f"{{kind: combined, parts: {{one: {SECTION}}}}}" if combined else SECTION
    series = "one.y" if combined else "y"
    path = folder / "problem.yaml"
    path.write_text(PROBLEM.replace("MODEL", model).replace("NAME", name).replace("SERIES", series))
    return path


@pytest.mark.parametrize("combined", [False, True])
@pytest.mark.parametrize("pest", ["E_oed", "e_oed", "E_OED"])
@pytest.mark.parametrize("own", ["{{E_oed}}", "7"])
def test_templates_of_pest_have_no_case(tmp_path: Path, pest: str, own: str, combined: bool) -> None:
    loaded = load_problem(problem(tmp_path, "E_oed", pest, own, combined=combined))
    assert loaded.free_names == ("E_oed",)
    (info, *_) = loaded.model.parameters
    assert info.name.lower() == "e_oed"


def test_other_templates_have(tmp_path: Path) -> None:
    with pytest.raises(ProblemError, match=r"parameters.e_oed: is missing \(Used by b, a\)|\(Used by a, b\)"):
        load_problem(problem(tmp_path, "E_oed", "E_oed", "{{e_oed}}", combined=False))


def test_a_name_that_is_none_is_reported(tmp_path: Path) -> None:
    with pytest.raises(ProblemError, match=r"parameters.e_eod: is missing \(Used by a\)"):
        load_problem(problem(tmp_path, "E_oed", "E_eod", "7", combined=False))


@pytest.mark.parametrize("written", ["{3: diverged}", '{"3": diverged}'])
def test_an_exit_status_needs_no_quotes(tmp_path: Path, written: str) -> None:
    path = problem(tmp_path, "E_oed", "E_oed", "7", combined=False)
    text = path.read_text().replace("run: [prog]", f"run: [prog], fail: {{exit: {written}}}")
    path.write_text(text)
    section = load_problem(path).document()["forward_model"]
    assert section["fail"]["exit"] == {"3": "diverged"}


def test_a_free_parameter_that_no_file_gets_is_reported(tmp_path: Path) -> None:
    path = problem(tmp_path, "E_oed", "e_oed", "7", combined=False)
    text = path.read_text().replace("1}}", "1}, k: {lower: 0, upper: 1}, n: {value: 2}}")
    path.write_text(text)
    told = r"parameters.k: is used by no template, and no file of all parameters is written \(write\)"
    with pytest.raises(ProblemError, match=told):
        load_problem(path)
    path.write_text(text.replace("run: [prog]", "run: [prog], write: {p.json: json}"))
    assert load_problem(path).free_names == ("E_oed", "k")
    path.write_text(text.replace("n: {value: 2}", "n: {expression: 2 * k}").replace("[prog]", "[prog, x]"))
    assert load_problem(path).free_names == ("E_oed", "k")
