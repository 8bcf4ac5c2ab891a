"""Where a replayed image lives and runs: in a folder of this machine, or in a Debian root of its own.

A container's root is a folder here. :class:`Here` runs with this machine's programs and rewrites paths; it can replay
what needs no root. :class:`Debian` changes the root: a Python of its own, the image's user without any capability, the
root mounted read-only, and of the rest only what Docker gives: /proc, a few devices, /dev/shm, secrets and the tmpfs of
/tmp with Docker's options. Its mounts are in a namespace of each process and end with it.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import ClassVar

from tests.servers import find_program

__all__ = ["Debian", "Here", "Machine"]

SECRETS = "/run/secrets"
_MOUNTS = f"""
set -eu
root=$1 secrets=$2 wheels=$3 way=$4; shift 4
mount --bind "$root" "$root"
mount -t proc proc "$root/proc"
mount -t tmpfs -o nosuid,mode=755 dev "$root/dev"
for name in null zero full random urandom; do : >"$root/dev/$name"; mount --bind "/dev/$name" "$root/dev/$name"; done
ln -s /proc/self/fd "$root/dev/fd"
mkdir "$root/dev/shm"
mount -t tmpfs -o nosuid,nodev,noexec,mode=1777,size=64m shm "$root/dev/shm"
if [ "$way" = build ]; then
    mkdir -p "$root/mnt/wheels"
    mount --bind "$wheels" "$root/mnt/wheels"
    exec chroot "$root" "$@"
fi
mount -t tmpfs -o nosuid,nodev,noexec,mode=1777,size=512m tmp "$root/tmp"
mount --bind "$secrets" "$root{SECRETS}"
mount -o remount,bind,ro "$root"
exec chroot "$root" /usr/bin/setpriv --reuid "$way" --regid "$way" --clear-groups --no-new-privs --bounding-set=-all \
    --inh-caps=-all --pdeathsig KILL -- "$@"
"""


class Machine(ABC):
    """Holds the roots of an image's stages and starts programs in them."""

    secrets: Path

    @abstractmethod
    def begin(self, base: str) -> Path:
        """Return the root of a new stage."""

    @abstractmethod
    def build(self, root: Path, script: str, environment: Mapping[str, str], folder: str) -> None:
        """Run a RUN line in a root; it must succeed."""

    @abstractmethod
    def command(self, root: Path, words: Sequence[str], environment: Mapping[str, str], folder: str) -> list[str]:
        """Return the arguments of a process that runs a program of the image as a container would."""

    def path(self, root: Path, inside: str) -> Path:
        """Return where a path of the image is on this machine."""
        return root / inside.lstrip("/")

    def rewritten(self, root: Path, text: str) -> str:  # noqa: ARG002  a machine with a real root rewrites nothing
        """Return a text of Dockerfile or compose file with its paths as they are on this machine."""
        return text


class Here(Machine):
    """Paths of the image lie below one folder for all stages, because programs know the path of their environment.

    Kernels run as plain Python, so that nothing is compiled for a minute.
    """

    VARIABLES: ClassVar = {"NUMBA_DISABLE_JIT": "1"}

    PATHS: ClassVar = re.compile(
        r"(?<![\w./])/(?=opt/geoswarm|build\b|run/secrets|tmp\b|var/lib/geoswarm|usr/local/bin|usr/share/doc/geoswarm)"
    )

    def __init__(self, folder: Path) -> None:
        self.root = folder / "root"
        self.secrets = self.path(self.root, SECRETS)
        for name in ("tmp", "run/secrets"):
            (self.root / name).mkdir(parents=True)

    def begin(self, base: str) -> Path:  # noqa: ARG002  the interpreter at hand, whatever the base
        """Return the one root."""
        return self.root

    def build(self, root: Path, script: str, environment: Mapping[str, str], folder: str) -> None:
        """Run it with the interpreter at hand first in PATH; pip's settings are this machine's."""
        path = f"{Path(sys.executable).parent}:{os.environ['PATH']}"
        done = subprocess.run(
            ["/bin/sh", "-euc", self.rewritten(root, script)],
            cwd=self.path(root, folder),
            env={**os.environ, **environment, **self.VARIABLES, "PATH": path},
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 0, f"RUN {script}\n{done.stdout[-2000:]}{done.stderr[-4000:]}"

    def command(self, root: Path, words: Sequence[str], environment: Mapping[str, str], folder: str) -> list[str]:
        """Run it with nothing of this environment, and with the test run gone, go too."""
        values = {name: self.rewritten(root, value) for name, value in {**environment, **self.VARIABLES}.items()}
        variables = [f"{name}={value}" for name, value in values.items()]
        move = 'cd "$0" && exec "$@"'
        follow = [str(find_program("setpriv")), "--pdeathsig", "KILL", "env", "-i"]
        return [*follow, *variables, "/bin/sh", "-c", move, str(self.path(root, folder)), *words]

    def rewritten(self, root: Path, text: str) -> str:
        """Return a text with the image's paths put below the folder."""
        return self.PATHS.sub(f"{root}/", text)


class Debian(Machine):
    """A minimal Debian as debootstrap makes it, of the release that the image's base names.

    Parameters
    ----------
    folder
        Empty; the roots of the stages are made in it.
    user
        Number of the image's user and group.
    """

    INCLUDED = "python3,python3-venv"

    def __init__(self, folder: Path, release: str, user: int) -> None:
        self.folder, self.user = folder, user
        self.secrets, self.wheels = folder / "secrets", folder / "wheels"
        for name in (self.secrets, self.wheels):
            name.mkdir()
        self._stages = 0
        self._pristine = folder / "pristine"
        options = ["--variant=minbase", f"--include={self.INCLUDED}", release, str(self._pristine)]
        done = subprocess.run(
            [str(find_program("debootstrap", [Path("/usr/sbin")])), *options],
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 0, f"debootstrap: {done.stdout[-3000:]}{done.stderr[-1000:]}"
        # the images of Python have it here, and call it python
        (self._pristine / "usr/local/bin/python").symlink_to("/usr/bin/python3")

    def begin(self, base: str) -> Path:  # noqa: ARG002  every stage begins with the same base
        """Return a copy of the pristine root."""
        root = self.folder / f"stage-{self._stages}"
        self._stages += 1
        subprocess.run(["cp", "--archive", "--reflink=auto", str(self._pristine), str(root)], check=True)
        (root / "run/secrets").mkdir()
        return root

    def fetch(self, requirements: Path) -> None:
        """Fetch the packages of a list, by their hashes, for this root's Python: the root itself reaches no network."""
        python = (self._pristine / "usr/bin/python3").readlink().name.removeprefix("python")
        chosen = self.folder / "requirements.txt"
        chosen.write_text(_for_python(requirements.read_text(encoding="utf-8"), python), encoding="utf-8")
        pip = [sys.executable, "-m", "pip", "download", "--quiet", "--no-deps", "--only-binary=:all:"]
        pip += ["--python-version", python, "--require-hashes", "--dest", str(self.wheels), "-r", str(chosen)]
        done = subprocess.run(pip, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr

    def build(self, root: Path, script: str, environment: Mapping[str, str], folder: str) -> None:
        """Run it as root of the image; pip finds the packages that were fetched."""
        offline = {"PIP_NO_INDEX": "1", "PIP_FIND_LINKS": "/mnt/wheels"}
        variables = {"PATH": "/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin", **offline, **environment}
        words = ["env", "-i", *(f"{name}={value}" for name, value in variables.items())]
        words += ["/bin/sh", "-euc", f"cd {folder}; {script}"]
        done = subprocess.run(
            self._in(root, "build", words), stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, f"RUN {script}\n{done.stdout[-2000:]}{done.stderr[-4000:]}"

    def command(self, root: Path, words: Sequence[str], environment: Mapping[str, str], folder: str) -> list[str]:
        """Run it as the image's user, in a read-only root."""
        variables = [f"{name}={value}" for name, value in environment.items()]
        moved = ["/bin/sh", "-c", 'cd "$0" && exec "$@"', folder, *words]
        return self._in(root, str(self.user), ["env", "-i", *variables, *moved])

    def _in(self, root: Path, way: str, words: Sequence[str]) -> list[str]:
        unshare = [str(find_program("unshare")), "--mount", "/bin/sh", "-c", _MOUNTS, "mounts"]
        return [*unshare, str(root), str(self.secrets), str(self.wheels), way, *words]


def whole_seconds(folder: Path) -> None:
    """Give files the times that they have after an image was pushed and pulled."""
    for path in folder.rglob("*"):
        if path.is_file() and not path.is_symlink():
            status = path.stat()
            os.utime(path, (int(status.st_atime), int(status.st_mtime)))


def copy(source: Path, target: Path) -> None:
    """Copy a file, or what is in a folder, as COPY does."""
    if source.is_dir():
        shutil.copytree(source, target, symlinks=True, dirs_exist_ok=True)
    else:
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(source, target)


def _for_python(requirements: str, python: str) -> str:
    """Keep the entries of a universal list whose marker holds for a version of Python on this machine."""
    from packaging.requirements import Requirement

    kept = []
    for entry in re.split(r"\n(?=\S)", re.sub(r"(?m)^\s*#.*\n?", "", requirements).strip()):
        line, *hashes = [part.strip() for part in entry.split("\\\n")]
        marker = Requirement(line).marker
        if marker is None or marker.evaluate({"python_version": python, "python_full_version": f"{python}.0"}):
            kept.append(" \\\n    ".join([line.split(";")[0].strip(), *hashes]))
    return "\n".join(kept) + "\n"
