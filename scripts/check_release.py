"""Check that every place that names the version names the same one, before a release.

python scripts/check_release.py v0.2.0           the tag that is to be released
python scripts/check_release.py v0.2.0 --notes   print what the changelog says of it
"""

from __future__ import annotations

import re
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PLACES = {
    "CITATION.cff": r"^version: (\S+)$",
    "docker-compose.yml": r"image: geoswarm:(\S+)",
    "deploy/kubernetes/kustomization.yaml": r"newTag: ([\w.]+)",
}
HEADING = re.compile(r"^## \[(?P<version>[\w.]+)\](?: - (?P<date>\d{4}-\d{2}-\d{2}))?$", re.MULTILINE)


def version(root: Path = ROOT) -> str:
    """Return the version of ``pyproject.toml``."""
    found: str = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))["project"]["version"]
    return found


def disagreements(root: Path = ROOT) -> list[str]:
    """Name the files that give another version than ``pyproject.toml``."""
    own = version(root)
    wrong = []
    for name, pattern in PLACES.items():
        match = re.search(pattern, (root / name).read_text(encoding="utf-8"), flags=re.MULTILINE)
        given = match[1] if match else "none"
        if given != own:
            wrong.append(f"{name}: version {given}, but pyproject.toml has {own}")
    return wrong


def notes(number: str, root: Path = ROOT) -> str | None:
    """Return what the changelog says of a version that has a date; None: it has no such heading."""
    text = (root / "CHANGELOG.md").read_text(encoding="utf-8")
    headings = list(HEADING.finditer(text))
    for heading, following in zip(headings, [*headings[1:], None], strict=True):
        if heading["version"] == number and heading["date"]:
            return text[heading.end() : following.start() if following else len(text)].strip() + "\n"
    return None


def main() -> int:
    """Return 1, and say why, where the tag cannot be released."""
    if len(sys.argv) < 2:
        print(__doc__)
        return 2
    number = sys.argv[1].removeprefix("v")
    wrong = disagreements()
    if number != version():
        wrong.append(f"tag {sys.argv[1]}: pyproject.toml has {version()}")
    said = notes(number)
    if said is None:
        wrong.append(f"CHANGELOG.md: has no heading `## [{number}] - YYYY-MM-DD`")
    if "--notes" in sys.argv[2:] and said is not None:
        print(said, end="")
    for line in wrong:
        print(line, file=sys.stderr)
    return int(bool(wrong))


if __name__ == "__main__":
    sys.exit(main())
