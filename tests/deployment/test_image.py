"""The image builds from what its build may see, and its services work: replayed without Docker, in a folder.

All RUN lines are carried out but the one that makes a user, with kernels as plain Python. The slow tests
(test_image_in_debian.py) carry out every line in a root of its own, and compile.
"""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tests.contracts.repository import ROOT
from tests.deployment.containers import running
from tests.deployment.dockerfile import copy_context
from tests.deployment.machines import Here
from tests.deployment.replay import Image, build_image
from tests.solver.problems import decay_document

pytestmark = pytest.mark.timeout(3600)

LEFT_OUT = ("useradd",)


@pytest.fixture(scope="module")
def image(tmp_path_factory: pytest.TempPathFactory) -> Image:
    """The image, in one folder for all its stages."""
    folder = tmp_path_factory.mktemp("image")
    built = build_image(Here(folder), folder / "context", LEFT_OUT)
    built.path("/opt/geoswarm/kernels").mkdir(exist_ok=True)  # nothing was compiled
    return built


def test_the_build_sees_only_what_git_knows_and_the_wheel_needs(tmp_path: Path) -> None:
    copy_context(ROOT, tmp_path)
    tops = {path.name for path in tmp_path.iterdir()}
    assert {"geoswarm", "api", "workers", "solver", "examples", "docs", "requirements", "hatch_build.py"} <= tops
    assert {"tests", ".git", ".venv", ".env", "secrets", "docker-compose.yml"}.isdisjoint(tops)
    assert (tmp_path / "geoswarm" / "api").is_symlink()
    assert not list(tmp_path.rglob("__pycache__"))
    assert [path.name for path in (tmp_path / "requirements").iterdir()] == ["image.txt"]


@pytest.mark.slow
def test_the_build_folder_is_enough(image: Image) -> None:
    done = image.run(["python", "-m", "pip", "check"], entrypoint=False)
    assert done.returncode == 0, done.stdout
    shown = image.run(["--version"])
    assert shown.stdout.startswith("geoswarm "), shown.stderr
    assert image.path("/usr/share/doc/geoswarm/THIRD-PARTY-LICENSES.md").is_file()
    where = image.run(["python", "-c", "import geoswarm; print(geoswarm.__file__)"], entrypoint=False)
    assert where.stdout.startswith(str(image.path("/opt/geoswarm"))), where.stderr
    assert Path(where.stdout.strip()).with_name("docs").joinpath("index.md").is_file()


@pytest.mark.slow
def test_every_service_is_healthy_and_a_job_goes_through(
    image: Image, fresh_postgres_url: str, fresh_redis_url: str, tmp_path: Path
) -> None:
    problem = "/tmp/problem.json"
    image.path(problem).write_text(json.dumps(decay_document()), encoding="utf-8")
    done = image.run(["run", problem, "--json"])
    assert done.returncode == 0, done.stderr
    alone = json.loads(done.stdout)
    with running(image, fresh_postgres_url, fresh_redis_url, tmp_path) as containers:
        job = containers.geoswarm("submit", problem, "--watch")
    for name in ("state", "stop_reasons", "objective", "parameters", "evaluations", "generations"):
        assert job[name] == alone[name], name
    assert job["state"] == "finished"
    log = (tmp_path / "prune.log").read_text()
    assert "prune: 0 jobs deleted" in log
