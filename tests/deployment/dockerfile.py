"""Reads Dockerfile and .dockerignore as Docker does, as far as this repository uses them; refuses the rest."""

from __future__ import annotations

import json
import re
import shlex
import shutil
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

__all__ = ["Instruction", "Stage", "copy_context", "read_dockerfile"]

KNOWN = {"COPY", "RUN", "ENV", "WORKDIR", "USER", "ENTRYPOINT", "CMD", "EXPOSE"}


@dataclass(frozen=True, slots=True)
class Instruction:
    """One instruction of a stage."""

    keyword: str
    text: str

    @property
    def words(self) -> list[str]:
        """Its arguments; those of ENTRYPOINT and CMD are JSON."""
        if self.keyword in ("ENTRYPOINT", "CMD"):
            words: list[str] = json.loads(self.text)
            return words
        return shlex.split(self.text)


@dataclass(frozen=True, slots=True)
class Stage:
    """From one FROM to the next."""

    base: str
    name: str
    instructions: tuple[Instruction, ...]

    def last(self, keyword: str) -> list[str]:
        """Return the arguments of the last instruction of a kind; there must be one."""
        return [instruction for instruction in self.instructions if instruction.keyword == keyword][-1].words

    @property
    def runs(self) -> list[str]:
        """The RUN lines."""
        return [instruction.text for instruction in self.instructions if instruction.keyword == "RUN"]


def read_dockerfile(text: str) -> list[Stage]:
    """Return the stages of a Dockerfile."""
    lines = [line for line in text.splitlines() if line.strip() and not line.lstrip().startswith("#")]
    stages: list[Stage] = []
    for line in re.sub(r"\\\n", " ", "\n".join(lines)).splitlines():
        keyword, _, rest = line.strip().partition(" ")
        if keyword == "FROM":
            base, *name = rest.split(" AS ")
            stages.append(Stage(base.strip(), name[0].strip() if name else str(len(stages)), ()))
            continue
        assert keyword in KNOWN, f"the replay does not know the instruction {keyword}"
        stage = stages.pop()
        stages.append(Stage(stage.base, stage.name, (*stage.instructions, Instruction(keyword, rest.strip()))))
    return stages


def copy_context(repository: Path, context: Path) -> None:
    """Copy what .dockerignore lets through, links as links, as `docker build` sends it."""
    rules = list(_rules((repository / ".dockerignore").read_text(encoding="utf-8")))
    tops = {rule.split("/")[0] for negated, rule in rules if negated}
    for path in sorted(path for top in tops for path in _files(repository / top)):
        relative = path.relative_to(repository)
        if not _ignored(relative.as_posix(), rules):
            (context / relative).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(path, context / relative, follow_symlinks=False)


def _rules(text: str) -> Iterator[tuple[bool, str]]:
    for line in text.splitlines():
        pattern = line.strip()
        if pattern and not pattern.startswith("#"):
            yield pattern.startswith("!"), pattern.removeprefix("!").strip("/")


def _ignored(path: str, rules: list[tuple[bool, str]]) -> bool:
    """The last rule that fits a path, or a folder that it lies in, decides."""
    names = [path, *(parent.as_posix() for parent in PurePosixPath(path).parents if parent.as_posix() != ".")]
    ignored = False
    for negated, pattern in rules:
        if any(re.fullmatch(_expression(pattern), name) for name in names):
            ignored = not negated
    return ignored


def _expression(pattern: str) -> str:
    signs = {"**/": "(?:.*/)?", "**": ".*", "*": "[^/]*", "?": "[^/]"}
    parts = re.split(r"(\*\*/|\*\*|\*|\?|\[[^\]]+\])", pattern)
    return "".join(signs.get(part, part if part.startswith("[") else re.escape(part)) for part in parts)


def _files(path: Path) -> Iterator[Path]:
    """All files and links below a path, without following links."""
    if path.is_symlink() or path.is_file():
        yield path
    elif path.is_dir():
        for entry in path.iterdir():
            yield from _files(entry)
