"""The image in a minimal Debian root: every RUN line, its user without capabilities, a read-only root, its ENV.

The nearest to `docker compose up --build` that needs no Docker. It needs root (debootstrap, mounts, chroot); without
root these tests fail and say how to run them. What Docker would add is not here: limits of memory and processors, its
networks.
"""

from __future__ import annotations

import json
import os
import re
import shutil
from pathlib import Path

import pytest

from tests.contracts.repository import ROOT
from tests.deployment.containers import running
from tests.deployment.machines import Debian
from tests.deployment.replay import Image, build_image, stages

pytestmark = [pytest.mark.slow, pytest.mark.timeout(3600)]

USER = 10001
KERNELS = "/opt/geoswarm/kernels"
SAME = ("state", "stop_reasons", "objective", "parameters", "evaluations", "generations")


def refusal() -> str | None:
    """Return why no Debian root can be made here, and what to do; None: it can."""
    if os.geteuid() != 0:
        return (
            "a Debian root is made, mounted and entered, which needs root; as somebody else run only these tests with: "
            "sudo .venv/bin/python -m pytest -m slow tests/deployment/test_image_in_debian.py"
        )
    if shutil.which("debootstrap", path=f"{os.environ.get('PATH', '')}:/usr/sbin") is None:
        return (
            "debootstrap is not installed: scripts/install_servers.sh installs it, or sudo apt-get install debootstrap"
        )
    return None


@pytest.fixture(scope="module")
def image(tmp_path_factory: pytest.TempPathFactory) -> Image:
    """The image, built in roots of the Debian release that its base names."""
    why = refusal()
    if why is not None:
        pytest.fail(why, pytrace=False)
    folder = tmp_path_factory.mktemp("debian")
    machine = Debian(folder, stages()[-1].base.rpartition("-")[2], USER)
    machine.fetch(ROOT / "requirements" / "image.txt")
    return build_image(machine, folder / "context")


def test_user_root_and_environment_are_those_of_the_image(image: Image) -> None:
    program = (
        "import os, re; status = open('/proc/self/status').read();"
        "print(os.getuid(), os.getcwd(), re.search(r'CapBnd:\\s*(\\w+)', status)[1])"
    )
    done = image.run(["python", "-c", program], entrypoint=False)
    assert done.stdout.split() == [str(USER), "/var/lib/geoswarm", "0" * 16], done.stderr
    for folder in ("/var/lib/geoswarm", "/opt/geoswarm", "/"):
        refused = image.run(["touch", f"{folder}/new"], entrypoint=False)
        assert "Read-only file system" in refused.stderr, folder
    assert image.run(["python", "-m", "pip", "check"], entrypoint=False).returncode == 0
    version = image.run(["--version"])
    assert re.fullmatch(r"geoswarm \d+\.\d+\.\d+\n", version.stdout), version.stderr
    assert image.run([]).returncode == image.run(["--help"]).returncode == 0


def test_every_service_is_healthy_a_job_goes_through_and_nothing_is_compiled(
    image: Image, fresh_postgres_url: str, fresh_redis_url: str, tmp_path: Path
) -> None:
    (problem,) = image.path("/opt/geoswarm/lib").glob(
        "python3.*/site-packages/geoswarm/examples/oedometer/problem.yaml"
    )
    inside = "/" + problem.relative_to(image.root).as_posix()
    done = image.run(["run", inside, "--json"])
    assert done.returncode == 0, done.stderr
    alone = json.loads(done.stdout)
    with running(image, fresh_postgres_url, fresh_redis_url, tmp_path) as containers:
        job = containers.geoswarm("submit", inside, "--watch")
        worker = containers.processes["worker"].pid
        used = {path.relative_to(image.path(KERNELS)) for path in files(image.path(KERNELS))}
        there = Path(f"/proc/{worker}/root/tmp/geoswarm-kernels")
        assert {path.relative_to(there) for path in files(there)} == used
        assert len(used) > 20
    assert {name: job[name] for name in SAME} == {name: alone[name] for name in SAME}
    assert job["state"] == "finished"


def test_the_demo_works_in_the_image(image: Image) -> None:
    done = image.run(["demo"])
    assert done.returncode == 0, done.stderr
    assert "lambda_star" in done.stdout
    assert "Traceback" not in done.stderr


def files(folder: Path) -> list[Path]:
    """Return the files below a folder."""
    return [path for path in folder.rglob("*") if path.is_file()]
