"""Problems made of a SYNTHETIC file are valid, say what was assumed, and describe the tests that they were made of."""

from __future__ import annotations

from pathlib import Path

import pytest

from geoswarm.solver.ags.contents import Contents, chosen, contents_of
from geoswarm.solver.ags.problem import Imported, imported
from geoswarm.solver.ags.reading import read_ags
from geoswarm.solver.ags.tables import AgsError
from geoswarm.solver.ags.wishes import Wishes
from geoswarm.solver.calibration import Calibration
from geoswarm.solver.external.copies import FileInTheWayError
from geoswarm.solver.forward.combined import CombinedSpec
from geoswarm.solver.forward.oedometer import OedometerSpec
from geoswarm.solver.laboratory.shear.triaxial import TriaxialSpec
from geoswarm.solver.problem import Problem, load_problem
from geoswarm.solver.problem.given import values_from
from geoswarm.solver.problem.parameters import FixedParameter, FreeParameter
from tests.solver.ags.synthetic import COHESION, E0, FIRST, PHI, STRESSES, content, group, groups, keyed, void_ratio


def some(*names: str, **other: str) -> Contents:
    found = contents_of(read_ags(content(**other), "synthetic.ags"))
    return chosen(found, names)


def made(folder: Path, contents: Contents, wishes: Wishes | None = None) -> tuple[Problem, str]:
    done = imported(contents, folder, wishes or Wishes())
    done.copies.write()
    return load_problem(folder / "problem.yaml"), "; ".join(done.notes)


def test_a_compression_test_becomes_an_oedometer_test(tmp_path: Path) -> None:
    problem, told = made(tmp_path, some("BH1/3/1"))
    spec = problem.forward_model
    assert isinstance(spec, OedometerSpec)
    assert (spec.material, spec.height, spec.initial_stress, spec.initial_void_ratio) == (
        "soft_soil",
        0.01925,
        1.2,
        1.2,
    )
    assert [(stage.stress, stage.duration) for stage in spec.stages] == [(stress, 1.0) for stress in STRESSES]
    (readings,) = problem.observations
    assert readings.series == "stage_void_ratio"
    assert readings.x.tolist() == list(range(1, 10))
    assert readings.y == pytest.approx(void_ratio(STRESSES), rel=1e-11)
    assert problem.parameters["lambda_star"] == FreeParameter("lambda_star", 0.01, 0.3, "log")  # the law's usual range
    assert problem.parameters["POP"] == FreeParameter("POP", 0.0, 800.0, "linear")
    assert problem.parameters["c"] == FixedParameter("c", 0.0)
    assert len(problem.constraints) == 1
    for words in (
        "1.2 kPa is assumed, a tenth",
        "24 h are assumed for each (--stage-duration), without effect with soft_soil",
        "say nothing about creep",
        "is CONS_IVR of the first increment",
    ):
        assert words in told
        assert words[:20] in (tmp_path / "problem.yaml").read_text()


def test_what_the_file_does_not_say_can_be_chosen(tmp_path: Path) -> None:
    problem, told = made(tmp_path, some("BH1/3/1"), Wishes(2.5, "soft_soil_creep", 5.0))
    spec = problem.forward_model
    assert isinstance(spec, OedometerSpec)
    assert (spec.initial_stress, spec.stages[0].duration) == (5.0, 2.5)
    assert isinstance(problem.parameters["mu_star"], FixedParameter)
    assert "60 h are assumed for each (--stage-duration);" in told
    assert "mu_star is fixed" in told
    with pytest.raises(AgsError, match="--initial-stress must be above 0 and below 12 kPa"):
        imported(some("BH1/3/1"), tmp_path / "a", Wishes(initial_stress=12.0))
    with pytest.raises(AgsError, match="--material: unknown law 'clay'"):
        imported(some("BH1/3/1"), tmp_path / "a", Wishes(material="clay"))


@pytest.mark.parametrize("material", ["modified_cam_clay", "hypoplastic_clay", "hypoplastic_sand", "mohr_coulomb"])
def test_other_laws_have_what_they_need(tmp_path: Path, material: str) -> None:
    problem, _ = made(tmp_path, some("BH1/3/1", "BH2/5/1"), Wishes(material=material))
    assert {part.kind for part in _parts(problem).values()} == {"oedometer"}


def _parts(problem: Problem) -> dict[str, object]:
    assert isinstance(problem.forward_model, CombinedSpec)
    return dict(problem.forward_model.parts)


def test_several_specimens_share_the_soil_but_not_its_past(tmp_path: Path) -> None:
    problem, _ = made(tmp_path, some("BH1/3/1", "BH2/5/1"))
    assert list(_parts(problem)) == ["BH1_3_1_4_60", "BH2_5_1_6_10"]
    assert list(problem.parameters) == ["lambda_star", "kappa_star", "c", "phi", "BH1_3_1_4_60.POP", "BH2_5_1_6_10.POP"]
    assert problem.weighting == "by_count"


def test_drained_tests_fit_the_strength_that_they_were_made_with(tmp_path: Path) -> None:
    problem, told = made(tmp_path, some("BH1/3/2"))
    parts = _parts(problem)
    assert len(parts) == 3
    for part, stress in zip(parts.values(), (50.0, 100.0, 200.0), strict=True):
        assert isinstance(part, TriaxialSpec)
        assert (part.material, part.drainage, part.initial_stress) == ("mohr_coulomb", "drained", stress)
    evaluation = Calibration(problem, 1).evaluate_values(values_from(problem, {"c": COHESION, "phi": PHI}))
    assert evaluation.reason is None, evaluation.message
    assert 0.0 <= evaluation.objective < 1e-6  # kPa², of deviator stresses of some 100 kPa
    assert "Mohr circles: c' 5 kPa, phi' 28 degree" in told
    assert "E and nu are fixed" in told


def test_undrained_tests_are_compared_by_pore_pressure_too(tmp_path: Path) -> None:
    problem, told = made(tmp_path, some("BH2/5/2"))
    assert [one.series.rpartition(".")[2] for one in problem.observations] == ["q", "pore_pressure"] * 3
    assert problem.observations[1].y.tolist() == [pytest.approx(300.0 + 100.0 - 45.0)]
    (part, *_) = _parts(problem).values()
    assert isinstance(part, TriaxialSpec)
    assert (part.material, part.drainage, part.back_pressure) == ("soft_soil", "undrained", 300.0)
    assert "taken as normally consolidated" in told


def test_compression_and_shear_tests_go_together(tmp_path: Path) -> None:
    problem, _ = made(tmp_path, some("BH1"))
    assert [part.kind for part in _parts(problem).values()] == ["oedometer", *["triaxial"] * 3]  # type: ignore[attr-defined]
    assert isinstance(problem.parameters["phi"], FreeParameter)
    assert problem.weighting == "by_range"


@pytest.mark.parametrize(
    ("name", "old", "new", "message"),
    [
        ("BH2/7/3", "", "", "UU, total stresses: the effective stress before shearing is not known"),
        ("BH1/3/2", '"CD"', '"CADE"', "the sign of q in extension is not laid down"),
        ("BH1/3/2", '"TRET_CONP"', '"TRET_XXXX"', r"\(TRET_CONP, or TRET_CVP and TRET_CRP\) is not given"),
        ("BH1/3/2", '"TRET_STRN"', '"TRET_XXXX"', r"\(TRET_STRN\) is not given"),
    ],
)
def test_what_makes_no_test_is_reported(tmp_path: Path, name: str, old: str, new: str, message: str) -> None:
    other = {one: groups()[one].replace(old, new) for one in ("TREG", "TRET")}
    with pytest.raises(AgsError, match=f"no problem can be made of these tests; .*{message}"):
        imported(some(name, **other), tmp_path, Wishes())


def test_of_several_stages_the_first_is_a_test(tmp_path: Path) -> None:
    problem, told = made(tmp_path, some("BH1/3/2", TREG=groups()["TREG"].replace('"CD"', '"CDM"')))
    assert isinstance(problem.forward_model, TriaxialSpec)
    assert "only the first is a test" in told
    assert "phi' 28 degree" in told


def test_readings_become_files_without_a_problem(tmp_path: Path) -> None:
    done = imported(some("BH3"), tmp_path, Wishes())
    assert isinstance(done, Imported)
    assert not done.problem
    assert list(done.copies.contents) == ["BH3_P1_PRES.csv", "BH3_P1_LEV.csv"]
    assert "readings that are not numbers are left out (1), the first 'DRY'" in "; ".join(done.notes)


def test_nothing_is_overwritten(tmp_path: Path) -> None:
    made(tmp_path, some("BH1/3/1"))
    with pytest.raises(AgsError, match=r"problem\.yaml exists and is never overwritten"):
        imported(some("BH1/3/1"), tmp_path, Wishes())
    (tmp_path / "BH3_P1_PRES.csv").write_text("mine")
    with pytest.raises(FileInTheWayError, match=r"BH3_P1_PRES\.csv exists with other contents"):
        imported(some("BH3"), tmp_path, Wishes())


def _many(increments: int) -> Contents:
    rows = [[*FIRST, str(n), E0, 10.0 + n, E0 - 1e-4 * n] for n in range(1, increments + 1)]
    columns = keyed(CONS_INCN=("", "X"), CONS_IVR=("", "3DP"), CONS_INCF=("kPa", "0DP"), CONS_INCE=("", "4DP"))
    return some("BH1/3/1", CONS=group("CONS", columns, rows))


def test_what_is_imported_can_be_loaded_or_is_refused(tmp_path: Path) -> None:
    problem, _ = made(tmp_path / "most", _many(1000))
    assert problem.counted_points == 1000
    with pytest.raises(AgsError, match=r"has 1001 increments, and a test takes at most 1000 stages: .* --specimen"):
        imported(_many(1001), tmp_path / "more", Wishes())
    with pytest.raises(AgsError, match=r"BH1/3/1.* makes no test that a problem accepts: oedometer\.stages.*, got 1"):
        imported(some("BH1/3/1"), tmp_path / "long", Wishes(duration=1e8))
