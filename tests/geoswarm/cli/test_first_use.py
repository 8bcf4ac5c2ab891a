"""The first use after an installation: kernels are compiled once, before the search, and wherever there is room."""

from __future__ import annotations

import json
import os
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

from geoswarm.solver.kernels.cache import cache_folder
from tests.installation import Installation, install

OEDOMETER = {
    "name": "oedometer",
    "forward_model": {
        "kind": "oedometer",
        "material": "soft_soil_creep",
        "height": 0.02,
        "initial_stress": 1.0,
        "stages": [{"stress": 50.0, "duration": 1.0}, {"stress": 20.0, "duration": 1.0}],
    },
    "parameters": {
        "lambda_star": {"lower": 0.05, "upper": 0.2},
        "kappa_star": {"value": 0.02},
        "mu_star": {"value": 1e-3},
        "c": {"value": 5.0},
        "phi": {"value": 20.0},
        "psi": {"value": 0.0},
    },
    "observations": [{"series": "settlement", "points": {"x": [1.0, 2.0], "y": [0.002, 0.002]}}],
    "method": {"kind": "particle_swarm", "particles": 8},
    "stopping": {"max_evaluations": 16},
    "seed": 1,
}
COMPILING = "Compiling the kernels for this machine: once after an installation.\n"


@pytest.fixture(scope="module")
def installation(tmp_path_factory: pytest.TempPathFactory) -> Installation:
    """An installation whose kernels nobody has compiled yet."""
    return install(tmp_path_factory.mktemp("fresh"))


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "problem.json").write_text(json.dumps(OEDOMETER), encoding="utf-8")
    return tmp_path


@pytest.mark.slow
def test_kernels_are_compiled_once_before_the_search(installation: Installation, folder: Path) -> None:
    first, second = (installation.geoswarm("run", "problem.json", "--json", folder=folder) for _ in range(2))
    assert (first.returncode, second.returncode) == (0, 0), first.stderr + second.stderr
    assert first.stderr.startswith(COMPILING)
    assert first.stderr.splitlines()[-1].startswith("Kernels compiled in ")
    assert second.stderr == ""
    one, two = json.loads(first.stdout), json.loads(second.stdout)
    assert two["compile_seconds"] == 0.0
    assert one["compile_seconds"] > one["seconds"]  # 16 runs of some milliseconds
    apart = {"seconds": 0, "compile_seconds": 0}
    assert one | apart == two | apart
    kernels = cache_folder(installation.packages / "geoswarm" / "solver")
    sources = {path.name.rpartition("-")[0] for path in kernels.iterdir() if path.is_dir()}
    assert {"axial", "physics", "step"} <= sources  # of this laboratory test, and nothing of the finite elements
    assert not {"newton", "triangle", "multifrontal"} & sources


@pytest.fixture
def locked(installation: Installation, folder: Path) -> Iterator[dict[str, str]]:
    """Neither the package nor the home can be written to; what is compiled already is put aside."""
    home, temporary = folder / "home", folder / "temporary"
    home.mkdir(mode=0o555)
    temporary.mkdir()
    solver = installation.packages / "geoswarm" / "solver"
    compiled = solver / "__pycache__"
    compiled.mkdir(exist_ok=True)  # nothing is compiled yet where this test runs alone
    aside = compiled.rename(solver / "aside")
    folders = [solver, *(path for path in solver.rglob("*") if path.is_dir())]
    for one in folders:
        one.chmod(0o555)
    yield {"HOME": str(home), "TMPDIR": str(temporary)}
    for one in folders:
        one.chmod(0o755)
    aside.rename(compiled)


@pytest.mark.slow
def test_without_a_place_for_kernels_a_temporary_folder_is_reported(
    installation: Installation, folder: Path, locked: dict[str, str]
) -> None:
    # Root may write anywhere, unless it gives that up.
    drop = "-dac_override,-dac_read_search"
    less = [] if os.geteuid() else ["setpriv", f"--bounding-set={drop}", f"--inh-caps={drop}"]
    answers = [
        subprocess.run(
            [*less, installation.script, *arguments],
            cwd=folder,
            env=installation.environment(**locked),
            capture_output=True,
            text=True,
            check=False,
        )
        for arguments in (("check", "problem.json"), ("run", "problem.json", "--workers", "2"))
    ]
    kept = Path(locked["TMPDIR"]) / f"geoswarm-{os.getuid()}"
    for answer in answers:
        assert answer.returncode == 0, answer.stderr
        (line,) = [line for line in answer.stderr.splitlines() if "NUMBA_CACHE_DIR" in line]
        assert line.startswith(f"the compiled kernels are kept in {kept}")
        assert str(installation.packages / "geoswarm") in line
        assert locked["HOME"] in line
    first, second = (answer.stderr for answer in answers)
    assert COMPILING in first
    assert COMPILING not in second
