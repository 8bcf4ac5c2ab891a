"""Replays the Dockerfile on a machine, and runs what it makes as containers of docker-compose.yml would."""

from __future__ import annotations

import shlex
import subprocess
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from tests.contracts.repository import ROOT
from tests.deployment.composition import ServiceSection
from tests.deployment.dockerfile import Instruction, Stage, copy_context, read_dockerfile
from tests.deployment.machines import Machine, copy, whole_seconds

__all__ = ["Image", "build_image", "stages"]

BASE_PATH = "/usr/local/bin:/usr/local/sbin:/usr/sbin:/usr/bin:/sbin:/bin"


def stages() -> list[Stage]:
    """Return the stages of the repository's Dockerfile."""
    return read_dockerfile((ROOT / "Dockerfile").read_text(encoding="utf-8"))


@dataclass(frozen=True, slots=True)
class Image:
    """What a Dockerfile has made: a root, and how programs are started in it."""

    machine: Machine
    root: Path
    environment: Mapping[str, str]
    folder: str
    entrypoint: Sequence[str]
    default: Sequence[str]

    def path(self, inside: str) -> Path:
        """Return where a path of the image is on this machine."""
        return self.machine.path(self.root, inside)

    def start(
        self, words: Sequence[str], environment: Mapping[str, str], log: Path, *, entrypoint: bool = True
    ) -> subprocess.Popen[bytes]:
        """Start a program as `docker run` does; what it prints goes to a file."""
        with log.open("ab") as output:
            return subprocess.Popen(
                self._command(words, environment, entrypoint),
                stdin=subprocess.DEVNULL,
                stdout=output,
                stderr=subprocess.STDOUT,
                start_new_session=True,
            )

    def run(
        self,
        words: Sequence[str],
        environment: Mapping[str, str] | None = None,
        *,
        entrypoint: bool = True,
        seconds: float = 600.0,
    ) -> subprocess.CompletedProcess[str]:
        """Run a program to its end."""
        return subprocess.run(
            self._command(words, environment or {}, entrypoint),
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            timeout=seconds,
            check=False,
        )

    def healthy(self, section: ServiceSection, replace: Mapping[str, str]) -> subprocess.CompletedProcess[str]:
        """Run the healthcheck of a service, with some words of it (a port) replaced."""
        words = [_replaced(word, replace) for word in section.healthcheck]
        return self.run(words, section.environment, entrypoint=False)

    def _command(self, words: Sequence[str], environment: Mapping[str, str], entrypoint: bool) -> list[str]:
        given = [self.machine.rewritten(self.root, word) for word in words]
        variables = {**self.environment, **environment}
        begin = [*self.entrypoint, *(given or self.default)] if entrypoint else given
        return self.machine.command(self.root, begin, variables, self.folder)


def _replaced(word: str, replace: Mapping[str, str]) -> str:
    for old, new in replace.items():
        word = word.replace(old, new)
    return word


def build_image(machine: Machine, context: Path, left_out: Sequence[str] = ()) -> Image:
    """Copy what the build may see into an empty folder and carry out the stages there.

    Parameters
    ----------
    left_out
        RUN lines that contain one of these words are not carried out; each word must leave out one.
    """
    copy_context(ROOT, context)
    roots: dict[str, Path] = {}
    skipped: list[str] = []
    image: Image | None = None
    for stage in stages():
        root = roots[stage.name] = machine.begin(stage.base)
        environment, folder = {"PATH": BASE_PATH}, "/"
        for instruction in stage.instructions:
            match instruction.keyword:
                case "WORKDIR":
                    folder = instruction.text
                    machine.path(root, folder).mkdir(parents=True, exist_ok=True)
                case "ENV":
                    for name, _, value in (word.partition("=") for word in instruction.words):
                        environment[name] = value.replace("$PATH", environment["PATH"])
                case "COPY":
                    _copy(instruction, context, roots, machine, root, folder)
                case "RUN":
                    dropped = [word for word in left_out if word in instruction.text]
                    skipped += dropped
                    if not dropped:
                        machine.build(root, instruction.text, environment, folder)
        if stage.name == stages()[-1].name:
            image = Image(machine, root, environment, folder, stage.last("ENTRYPOINT"), stage.last("CMD"))
    assert sorted(skipped) == sorted(left_out)
    assert image is not None
    return image


def _copy(
    instruction: Instruction, context: Path, roots: Mapping[str, Path], machine: Machine, root: Path, folder: str
) -> None:
    words = shlex.split(instruction.text)
    origin = context
    if words[0].startswith("--from="):
        origin = roots[words.pop(0).partition("=")[2]]
    *sources, target = words
    inside = target if target.startswith("/") else f"{folder.rstrip('/')}/{target}"
    for name in sources:
        source = origin / name.lstrip("/")
        into = inside.endswith(("/", "/.")) and not source.is_dir()
        destination = machine.path(root, inside) / source.name if into else machine.path(root, inside)
        if source != destination:  # on this machine all stages share a root
            copy(source, destination)
            if origin is not context:
                whole_seconds(destination)
