"""What MkDocs needs to know of this repository: links out of ``docs`` and diagrams.

Pages are written to be read in the repository, too: they link to examples, tests and sources beside ``docs``. On the
site each of them has a place of its own: a folder is its README, other files are shown as they are. Diagrams in Mermaid
are the pictures that ``docs/draw_diagrams.py`` made of them, so that a page loads nothing from elsewhere.
"""

from __future__ import annotations

import hashlib
import os
import posixpath
import re
from pathlib import Path
from typing import Any

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page

ROOT = Path(__file__).resolve().parents[1]
DOCS = ROOT / "docs"
LISTED = ("examples", "decisions")
LINK = re.compile(r"(?<=\]\()(?!https?:|mailto:|#)([^)\s#]+)(#[^)\s]*)?(?=[)\s])")
FENCE = re.compile(r"^(```|~~~).*?^\1[ ]*$", re.DOTALL | re.MULTILINE)
MERMAID = re.compile(r"^```mermaid\n(.*?)^```$", re.DOTALL | re.MULTILINE)


def diagram(source: str) -> str:
    """Return the name of the picture of a diagram: of its text, so that a changed one is a missing one."""
    return hashlib.sha256(source.encode()).hexdigest()[:12] + ".svg"


def place(page: str, link: str) -> Path:
    """Return the file of the repository that a link of a page means; a folder is its README."""
    folder = (DOCS / page).parent if page != "readme.md" and (DOCS / page).exists() else (ROOT / page).parent
    target = Path(os.path.normpath(folder / link))
    return target / "README.md" if target.is_dir() else target


def uri(target: Path) -> str:
    """Return the place of a file on the site: pages of ``docs`` at the top, all else as in the repository."""
    if target == ROOT / "README.md":  # else the README would be the first page, in place of docs/index.md
        return "readme.md"
    return target.relative_to(DOCS if target.is_relative_to(DOCS) else ROOT).as_posix()


def listing(folder: str) -> tuple[str, list[str]]:
    """Return the page of a folder without one, a list of what is in it, and the places of the pages listed."""
    paths = sorted((DOCS / folder).glob("[0-9]*.md") if folder == "decisions" else (ROOT / folder).glob("*/README.md"))
    titles = [path.read_text(encoding="utf-8").partition("\n")[0].removeprefix("# ") for path in paths]
    items = [f"- [{title}]({uri(path).removeprefix(f'{folder}/')})" for title, path in zip(titles, paths, strict=True)]
    return "\n".join([f"# {folder.capitalize()}", "", *items, ""]), [uri(path) for path in paths]


def outside(page: str, text: str) -> set[Path]:
    """Return the files of the repository outside ``docs`` that a page links to."""
    found = (place(page, match[1]) for match in LINK.finditer(FENCE.sub("", text)))
    return {p for p in found if p.is_relative_to(ROOT) and not p.is_relative_to(DOCS) and p.is_file()}


def on_config(config: MkDocsConfig) -> MkDocsConfig:
    """List examples and decisions in the menu: a new one needs no line there."""
    listed = {f"{folder}/": [f"{folder}/README.md", *listing(folder)[1]] for folder in LISTED}

    def filled(item: Any) -> Any:
        if isinstance(item, dict):
            return {name: filled(value) for name, value in item.items()}
        if isinstance(item, list):
            return [filled(value) for value in item]
        return listed.get(item, item)

    config.nav = filled(config.nav)
    return config


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add what pages link to outside ``docs``, and what those pages link to."""
    pages = [(file.src_uri, file.content_string) for file in files.documentation_pages()]
    for folder in LISTED:
        files.append(File.generated(config, f"{folder}/README.md", content=listing(folder)[0]))
    extra = {ROOT / "CHANGELOG.md", *(ROOT / "examples").glob("*/README.md")}
    pending = list(extra)
    for page, text in pages:
        pending += outside(page, text)
    while pending:
        path = pending.pop()
        place_of = uri(path)
        if place_of in files.src_uris:
            continue
        if path.suffix == ".md":
            text = path.read_text(encoding="utf-8")
            files.append(File.generated(config, place_of, content=text))
            pending += outside(place_of, text)
        else:
            files.append(File.generated(config, place_of, abs_src_path=str(path)))
    return files


def on_page_markdown(markdown: str, page: Page, config: MkDocsConfig, files: Files) -> str:  # noqa: ARG001
    """Point links at the places of this site, and show diagrams as pictures."""
    here = page.file.src_uri

    def pointed(match: re.Match[str]) -> str:
        target = place(here, match[1])
        if not target.exists() and uri(target) not in {f"{folder}/README.md" for folder in LISTED}:
            return match[0]
        relative = posixpath.relpath(uri(target), posixpath.dirname(here) or ".")
        return relative + (match[2] or "")

    def drawn(match: re.Match[str]) -> str:
        name = diagram(match[1])
        if not (DOCS / "pictures" / "diagrams" / name).is_file():
            raise SystemExit(f"docs: {here} has a diagram without picture: run python docs/draw_diagrams.py")
        to = posixpath.relpath(f"pictures/diagrams/{name}", posixpath.dirname(here) or ".")
        return f"![Diagram]({to})"

    parts = re.split(r"(^```.*?^```[ ]*$)", markdown, flags=re.DOTALL | re.MULTILINE)
    return "".join(MERMAID.sub(drawn, part) if i % 2 else LINK.sub(pointed, part) for i, part in enumerate(parts))
