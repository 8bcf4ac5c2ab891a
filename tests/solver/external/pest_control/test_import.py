"""A control file becomes a problem with PEST's own objective; what is not carried over is told."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import pytest

from geoswarm.solver.calibration import Calibration
from geoswarm.solver.external.pest_control.case import PestCase, PestControlError, PestObservation, PestPair
from geoswarm.solver.external.pest_control.problem import imported
from geoswarm.solver.problem import Problem, load_problem
from geoswarm.solver.problem.given import values_from
from geoswarm.solver.problem.parameters import FixedParameter, FreeParameter, LinkedParameter
from tests.solver.external.pest_control.beam import BEAM, FOLDER, case, phi


@pytest.fixture(autouse=True)
def own_rooms(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.setattr("tempfile.tempdir", None)


def made(folder: Path, one: PestCase = BEAM, files: tuple[str, ...] = ()) -> Problem:
    imported(one, folder, files).copies.write()
    return load_problem(folder / "problem.yaml")


@pytest.mark.parametrize(
    "values",
    [
        {"e-1": 2e4, "load": 1.5, "pi": 0.2},
        {"e-1": 1.1e3, "load": 4.9, "pi": 1.0},
        {"e-1": 123456.78901, "load": 0.5, "pi": 0.0},
    ],
)
def test_the_objective_is_that_of_pest(tmp_path: Path, values: dict[str, float]) -> None:
    problem = made(tmp_path / "made")
    given = {"e_1": values["e-1"], "load_pest": values["load"], "pa": values["pi"]}
    evaluation = Calibration(problem, 1).evaluate_values(values_from(problem, given))
    assert evaluation.reason is None, evaluation.message
    # the spaces of the templates hold 12 digits and more
    assert evaluation.objective == pytest.approx(phi(values), rel=1e-9)


def test_parameters_are_transformed_tied_scaled_and_fixed(tmp_path: Path) -> None:
    problem = made(tmp_path / "made")
    found = problem.parameters
    assert list(found) == ["e_1", "e_2", "load_pest", "load", "load2", "span", "pa"]
    assert found["e_1"] == FreeParameter("e_1", 1e3, 1e6, "log", 2e4)
    assert found["load_pest"] == FreeParameter("load_pest", 0.5, 5.0, "linear", 1.5)
    assert found["span"] == FixedParameter("span", 8.5)
    values = values_from(problem, {"e_1": 5e3, "load_pest": 2.0})
    assert values["e_2"] == 2.5e3
    assert (values["load"], values["load2"]) == (15.0, 41.0)
    assert isinstance(found["load2"], LinkedParameter)


def test_each_instruction_file_and_group_is_a_series(tmp_path: Path) -> None:
    problem = made(tmp_path / "made")
    assert [info.name for info in problem.model.series] == ["defl_defl", "force", "spare", "defl_forces", "regul_x"]
    observed = {one.series: one for one in problem.observations}
    assert list(observed) == ["defl_defl", "force", "defl_forces", "regul_x"]
    assert observed["defl_defl"].x.tolist() == [1.0, 2.0, 3.0, 3.5]
    assert observed["defl_defl"].y.tolist() == [1.7, 3.1, 4.6, 5.6]
    assert observed["defl_defl"].point_weights.tolist() == [100.0, 25.0, 4.0, 0.0]
    assert (observed["defl_defl"].weight, observed["force"].weight) == (4.0, 2.0)
    assert observed["force"].x.tolist() == [1.0, 2.0]


def test_what_is_told_stands_in_the_file_too(tmp_path: Path) -> None:
    made_of = imported(BEAM, tmp_path / "made")
    notes = "\n".join(made_of.notes)
    assert "PESTMODE estimation is ignored" in notes
    assert "group spare: all weights are 0" in notes
    assert "group regul_x is for regularisation" in notes
    assert "parameter e-1 is called e_1" in notes
    assert "parameter pi is called pa" in notes
    made_of.copies.write()
    text = (tmp_path / "made" / "problem.yaml").read_text()
    head = " ".join(line.lstrip("#- ") for line in text.splitlines() if line.startswith("#"))
    assert all(" ".join(note.split()) in head for note in made_of.notes)
    assert "x is the number at the end of the names" in text
    assert "force; x is the running number" in text


def test_files_are_copied_and_spaces_stay_as_wide(tmp_path: Path) -> None:
    made(tmp_path)
    for name in ("defl.ins", "forces.ins", "beam_model"):
        assert (tmp_path / name).read_bytes() == (FOLDER / name).read_bytes()
    theirs, ours = (FOLDER / "beam.tpl").read_text(), (tmp_path / "beam.tpl").read_text()
    assert ours == theirs.replace("e-1", "e_1").replace("e-2", "e_2")
    assert (tmp_path / "span.tpl").read_text() == (FOLDER / "span.tpl").read_text().replace("PI", "pa")


def test_a_problem_beside_the_control_file_changes_nothing_there(tmp_path: Path) -> None:
    folder = tmp_path / "beam"
    shutil.copytree(FOLDER, folder)
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    problem = made(folder, case(path=folder / "beam.pst"))
    assert problem.forward_model.model_dump()["templates"] == {"in/beam.dat": "beam_2.tpl", "span.dat": "span_2.tpl"}
    assert {name: (folder / name).read_bytes() for name in before} == before
    with pytest.raises(PestControlError, match=r"problem\.yaml exists and is never overwritten"):
        imported(case(path=folder / "beam.pst"), folder)


def test_other_files_are_named_and_copied_when_asked_for(tmp_path: Path) -> None:
    folder = tmp_path / "beam"
    shutil.copytree(FOLDER, folder)
    (folder / "tables").mkdir()
    (folder / "tables" / "steel.csv").write_text("1,2\n")
    (folder / "beam.rec").write_text("record\n")
    one = case(path=folder / "beam.pst")
    told = next(note for note in imported(one, tmp_path / "a").notes if "beside the control file lie" in note)
    assert "tables/" in told
    assert "beam.rec" not in told
    problem = made(tmp_path / "b", one, ("tables",))
    assert (tmp_path / "b" / "tables" / "steel.csv").read_text() == "1,2\n"
    assert problem.forward_model.model_dump()["files"] == ("beam_model", "tables")
    with pytest.raises(PestControlError, match="--files nothing: is not in"):
        imported(one, tmp_path / "c", ("nothing",))


def test_a_command_line_for_a_shell_is_left_to_the_user(tmp_path: Path) -> None:
    one = imported(case(commands=("python3 beam_model --span < span.dat > log",)), tmp_path)
    assert any("needs a shell (for <)" in note and "run.sh" in note for note in one.notes)
    one.copies.write()
    text = (tmp_path / "problem.yaml").read_text()
    assert "  run: [sh, run.sh]\n  files: [run.sh]\n" in text
    assert "  # python3 beam_model --span < span.dat > log\n" in text
    assert not (tmp_path / "run.sh").exists()


def changed(index: int, **changes: object) -> PestCase:
    listed = list(BEAM.parameters)
    listed[index] = replace(listed[index], **changes)  # type: ignore[arg-type]
    return case(parameters=tuple(listed))


@pytest.mark.parametrize(
    ("one", "message"),
    [
        (changed(1, tied_to="e-9"), "parameter e-2 is tied to 'e-9', which is not a parameter"),
        (changed(3, tied_to="e-2"), "load2 is tied to 'e-2', which is tied itself"),
        (changed(0, value=0.0), "tied to e-1, whose initial value is 0"),
        (changed(0, lower=0.0), "e-1 is searched by its logarithm and has the lower bound 0"),
        (case(parameters=BEAM.parameters[:-1]), "templates use pi, which are not parameters"),
        (case(templates=(PestPair("no.tpl", "a"),)), "no.tpl: cannot be read"),
        (case(templates=(PestPair("defl.ins", "a"),)), "defl.ins: line 1: 'pif .' must be ptf"),
        (case(instructions=(PestPair("beam.tpl", "a"),)), "beam.tpl: line 1: 'ptf %' must be pif"),
        (case(templates=(PestPair("beam.tpl", "../a"),)), r"'\.\./a' must stay in the folder of the run"),
        (case(instructions=BEAM.instructions[:1]), "6 observations are read by no instruction file, the first north"),
        (
            case(observations=tuple(replace(o, weight=0.0) for o in BEAM.observations)),
            "all observations have weight 0",
        ),
    ],
)
def test_what_makes_no_problem_is_reported(tmp_path: Path, one: PestCase, message: str) -> None:
    with pytest.raises(PestControlError, match=message):
        imported(one, tmp_path / "made")
    assert not (tmp_path / "made").exists()


def test_equal_bounds_fix_and_a_tie_to_what_is_fixed_is_a_value(tmp_path: Path) -> None:
    problem = made(tmp_path / "made", changed(0, lower=2e4, upper=2e4))
    assert problem.parameters["e_1"] == FixedParameter("e_1", 2e4)
    assert problem.parameters["e_2"] == FixedParameter("e_2", 1e4)


def test_groups_of_more_observations_than_a_mapping_has_become_several(tmp_path: Path) -> None:
    for name in ("beam.tpl", "span.tpl", "beam_model"):
        shutil.copy(FOLDER / name, tmp_path)
    names = [f"h{n}" for n in range(10_001)]
    (tmp_path / "many.ins").write_text("pif $\n" + "".join(f"l1 !{name}!\n" for name in names))
    one = case(
        path=tmp_path / "many.pst",
        observations=tuple(PestObservation(name, 1.0, 1.0, "l_heads") for name in names),
        instructions=(PestPair("many.ins", "many.out"),),
    )
    assert any("l_heads is an inequality" in note for note in imported(one, tmp_path / "made").notes)
    problem = made(tmp_path / "made", one)
    assert [(o.series, len(o.x), o.weight) for o in problem.observations] == [
        ("l_heads", 10_000, 10_000.0),
        ("l_heads_2", 1, 1.0),
    ]
