"""Forward models found by kind, built-in and installed."""

from __future__ import annotations

import sys
import tomllib
from collections.abc import Iterator
from importlib.metadata import EntryPoint
from pathlib import Path
from typing import Literal

import pytest
from pydantic import ValidationError

from geoswarm.solver.errors import BrokenForwardModelError, ProblemError, UnknownForwardModelError
from geoswarm.solver.forward import registry
from geoswarm.solver.forward.base import ForwardModel, ForwardModelSpec
from geoswarm.solver.forward.formula import FormulaSpec
from geoswarm.solver.forward.registry import GROUP, find_spec, kinds, parse_spec, sketches_of
from geoswarm.solver.problem import parse_problem, problem_schema
from geoswarm.solver.sketches.declared import Sketch

BUILT_IN = (
    "formula",
    "combined",
    "oedometer",
    "isotropic_compression",
    "triaxial",
    "crs_oedometer",
    "consolidation",
    "direct_simple_shear",
    "column",
    "section",
    "finite_element",
    "command",
    "python",
    "umbridge",
    "registered",
)


class LineSpec(ForwardModelSpec):
    """A forward model of another package."""

    kind: Literal["line"] = "line"
    slope: float

    def build(self) -> ForwardModel:
        """A line."""
        return FormulaSpec.model_validate({"series": {"y": f"{self.slope} * x + a"}}).build()


class UnbuildableSpec(ForwardModelSpec):
    """A forward model that cannot be built from its section."""

    kind: Literal["unbuildable"] = "unbuildable"

    def build(self) -> ForwardModel:
        """Refuses."""
        raise ValueError("the mesh has a hole")


class BlotSpec(ForwardModelSpec):
    """A line whose sketch is broken."""

    kind: Literal["blot"] = "blot"
    slope: float

    def sketch(self) -> Sketch:
        """Fails as anybody's code may."""
        raise ZeroDivisionError("no height")

    def build(self) -> ForwardModel:
        """A line."""
        return LineSpec(slope=self.slope).build()


@pytest.fixture
def installed(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    this = sys.modules[__name__]
    monkeypatch.setitem(sys.modules, "some_package", this)
    entries = [
        EntryPoint("line", "some_package:LineSpec", GROUP),
        EntryPoint("unbuildable", "some_package:UnbuildableSpec", GROUP),
        EntryPoint("blot", "some_package:BlotSpec", GROUP),
        EntryPoint("formula", "some_package:LineSpec", GROUP),
        EntryPoint("absent", "no_such_package:Spec", GROUP),
        EntryPoint("nameless", "some_package:NoSuchSpec", GROUP),
        EntryPoint("wrong", "some_package:BUILT_IN", GROUP),
    ]
    monkeypatch.setattr(
        "geoswarm.solver.system.installed.entry_points", lambda group: entries if group == GROUP else []
    )
    registry.forget()
    yield
    monkeypatch.undo()
    registry.forget()


def test_the_built_in_models_are_those_of_the_package() -> None:
    pyproject = tomllib.loads((Path(__file__).parents[3] / "pyproject.toml").read_text(encoding="utf-8"))
    declared = pyproject["project"]["entry-points"][GROUP]
    assert declared == registry.BUILT_IN
    assert kinds()[: len(BUILT_IN)] == BUILT_IN


@pytest.mark.parametrize("kind", BUILT_IN)
def test_built_in_models_are_found(kind: str) -> None:
    spec = find_spec(kind)
    assert issubclass(spec, ForwardModelSpec)
    assert spec.model_fields["kind"].default == kind


def test_unknown_kind() -> None:
    with pytest.raises(
        UnknownForwardModelError, match="unknown kind 'oedometre'; did you mean oedometer\\?; known kinds: form"
    ):
        find_spec("oedometre")


@pytest.mark.usefixtures("installed")
def test_models_of_other_packages() -> None:
    assert kinds() == (*BUILT_IN, "absent", "blot", "line", "nameless", "unbuildable", "wrong")
    assert find_spec("line") is LineSpec
    assert find_spec("formula") is FormulaSpec
    spec = parse_spec({"kind": "line", "slope": 2})
    assert spec == LineSpec(slope=2.0)
    assert parse_spec(spec) is spec


@pytest.mark.usefixtures("installed")
@pytest.mark.parametrize(
    ("kind", "message"),
    [
        ("absent", r"'absent' \(no_such_package:Spec\) is installed but cannot be loaded: No module named"),
        ("nameless", r"'nameless' \(some_package:NoSuchSpec\) is installed but cannot be loaded: .* no attribute"),
        ("wrong", r"'wrong' \(some_package:BUILT_IN\) is installed but is not a subclass of"),
    ],
)
def test_a_broken_model_harms_no_other(kind: str, message: str) -> None:
    with pytest.raises(BrokenForwardModelError, match=message):
        find_spec(kind)
    with pytest.raises(ValidationError, match=message):
        parse_spec({"kind": kind})
    assert find_spec("line") is LineSpec
    assert "forward_model_line" in problem_schema()["$defs"]
    assert f"forward_model_{kind}" not in problem_schema()["$defs"]


@pytest.mark.usefixtures("installed")
def test_a_problem_with_a_model_of_another_package() -> None:
    document = {
        "forward_model": {"kind": "line", "slope": 2},
        "parameters": {"a": {"lower": 0, "upper": 1}},
        "observations": [{"series": "y", "points": {"x": [1], "y": [2]}}],
        "stopping": {"max_seconds": 1},
    }
    assert parse_problem(document).document()["forward_model"] == {"kind": "line", "slope": 2.0}
    with pytest.raises(ProblemError, match=r"^forward_model: the mesh has a hole$"):
        parse_problem(document | {"forward_model": {"kind": "unbuildable"}})


@pytest.mark.parametrize("section", [3, None, [], {"series": {}}, {"kind": 3}])
def test_a_section_without_kind(section: object) -> None:
    with pytest.raises(ValidationError, match="known kinds: formula, combined"):
        parse_spec(section)


def test_sections_are_validated_strictly() -> None:
    section = {"kind": "oedometer", "height": "0.02", "initial_stress": True, "stages": [{"stress": 1, "duration": 1}]}
    with pytest.raises(ValidationError) as caught:
        parse_spec(section)
    assert [error["loc"] for error in caught.value.errors()] == [("height",), ("initial_stress",)]


@pytest.mark.usefixtures("installed")
def test_a_sketch_that_fails_is_left_out(caplog: pytest.LogCaptureFixture) -> None:
    parts = {"line": {"kind": "blot", "slope": 2}, "oedometer": find_spec("oedometer").example()}
    assert list(sketches_of(parse_spec({"kind": "combined", "parts": parts}))) == ["oedometer"]
    assert "forward model 'blot' has no sketch: it raised ZeroDivisionError: no height" in caplog.text
