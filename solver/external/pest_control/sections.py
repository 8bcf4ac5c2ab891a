"""The sections of a control file that a problem cannot carry over: each is reported with its contents."""

from __future__ import annotations

import re

from geoswarm.solver.external.pest_control.case import PestControlError

__all__ = ["Sections", "external_files", "left_out", "plain_text", "sections_of", "with_exponents"]

Sections = dict[str, list[str]]
"""Lines by heading in lower case, without ``external`` and ``keyword``; ``++`` holds options of PEST++."""

PLUS = "++"
_CARRIED = ("control data", "parameter data", "observation data", "model command line")
_FILES = ("model input/output", "model input", "model output")
_IN_WORDS = {
    "prior information": "prior information is not carried over ({count} equations): add what it says as constraints",
    "regularisation": "regularisation is not carried over: PEST's extra term of the objective is missing",
    "singular value decomposition": "settings of the singular value decomposition are not needed: the search has none",
    "svd assist": "SVD-assist is not carried over: all free parameters are searched",
    "lsqr": "settings of LSQR are not needed: the search solves no such equations",
    "automatic user intervention": "automatic user intervention is not carried over: no parameter is held meanwhile",
    "sensitivity reuse": "reuse of sensitivities is not needed: the search takes no derivatives",
    "derivatives command line": "the command for derivatives is not carried over: the search takes no derivatives",
    "predictive analysis": "predictive analysis is not carried over: geoswarm profile and posterior give intervals",
    "pareto": "the Pareto mode is not carried over: one problem has one objective",
    "parameter groups": "increments of parameter groups are not needed: the search takes no derivatives",
}
_FORTRAN = re.compile(r"(?<![\w.])([+-]?(?:\d+\.?\d*|\.\d+))[dD]([+-]?\d+)(?![\w.])", re.ASCII)
_FIRST = ("restart", "norestart")
_KEYWORD = re.compile(r"\s*(external|keyword)$")


def sections_of(text: str) -> Sections:
    """Return the lines of each section, without comments.

    Raises
    ------
    PestControlError
        The first line is not ``pcf``.
    """
    lines = [line.strip() for line in text.splitlines()]
    lines = [line for line in lines if line and not line.startswith("#")]
    if not lines or lines[0].split()[0].lower() != "pcf":
        first = lines[0][:40] if lines else ""
        raise PestControlError(f"is not a PEST control file: its first line must be pcf, got '{first}'")
    found: Sections = {}
    current: list[str] = []
    for line in lines[1:]:
        if line.startswith(PLUS):
            found.setdefault(PLUS, []).append(line.removeprefix(PLUS).strip())
        elif line.startswith("*"):
            heading = _KEYWORD.sub("", " ".join(line.removeprefix("*").lower().split()))
            current = found.setdefault(heading.replace("regularization", "regularisation"), [])
        else:
            current.append(line)
    return found


def with_exponents(text: str) -> str:
    """Numbers of Fortran as others write them: ``1.0D+02`` is 1.0e+02."""
    return _FORTRAN.sub(r"\1e\2", text)


def plain_text(text: str) -> str:
    """A control file in small letters, but for names of files and commands, and with exponents that pyEMU reads."""
    lines, heading = [], ""
    for line in text.splitlines():
        plain = line.strip()
        if plain.startswith("*"):
            heading = " ".join(plain.removeprefix("*").lower().split())
            line = f"* {heading}"
        elif plain.startswith(("#", PLUS)):
            pass
        elif not heading:
            line = line.lower() if plain[:3].lower() == "pcf" else line
        elif heading in ("parameter data", "observation data"):
            first, *rest = plain.lower().split(maxsplit=1) or [""]
            line = " ".join([first, *map(with_exponents, rest)])
        elif heading in ("control data", "parameter groups", "observation groups"):
            line = with_exponents(line.lower())
        lines.append(line)
    return "\n".join(lines) + "\n"


def external_files(text: str) -> list[str]:
    """Names of the files of data that a control file of version 2 has beside it."""
    found, external = [], False
    for line in text.splitlines():
        words = line.split()
        if line.startswith("*"):
            external = words[-1] == "external"
        elif external and words and not line.startswith(("#", PLUS)):
            found.append(re.split(r"[/\\]", words[0])[-1])
    return found


def left_out(sections: Sections) -> list[str]:
    """What a problem made of these sections does not have, in words, one text a matter."""
    notes = []
    mode = _mode(sections.get("control data", []))
    if mode:
        notes.append(f"PESTMODE {mode} is ignored: the problem is an estimation by the method that it names")
    notes.append("limits of steps and of iterations (PARCHGLIM, RELPARMAX, NOPTMAX ...) are not needed: see stopping")
    keys = _keys(sections.get("control data", []))
    if keys:
        notes.append(f"settings of the control data are not carried over: {', '.join(keys)}")
    for heading, lines in sections.items():
        if heading in (*_CARRIED, *_FILES) or not lines:
            continue
        if heading == PLUS:
            names = ", ".join(dict.fromkeys(name for line in lines for name in re.findall(r"[\w-]+(?=\()", line)))
            notes.append(f"options of PEST++ are not carried over: {names or ' '.join(lines)[:100]}")
        elif heading == "observation groups":
            notes += [
                f"observation group {line.split()[0].lower()}: the covariance matrix {line.split()[1]} is not carried "
                "over: the weights of its observations are those of the control file"
                for line in lines
                if len(line.split()) > 1
            ]
        elif heading in _IN_WORDS:
            notes.append(_IN_WORDS[heading].format(count=len(lines)))
        else:
            notes.append(f"section '{heading[:60]}' is not carried over ({len(lines)} lines)")
    return notes


def _keys(lines: list[str]) -> list[str]:
    """Names in control data that are keywords and values; none where they are the numbers of version 1."""
    words = [line.split()[0].lower() for line in lines]
    keyword = bool(words) and all(re.match(r"[a-z]", word) for word in words) and words[0] not in _FIRST
    return [word for word in dict.fromkeys(words) if word not in ("pestmode", "noptmax")] if keyword else []


def _mode(lines: list[str]) -> str:
    """PESTMODE, of either form of the section."""
    for line in lines:
        for word in line.lower().split():
            if word in ("estimation", "prediction", "regularisation", "regularization", "pareto"):
                return word
    return ""
