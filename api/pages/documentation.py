"""The documentation of the installed version, as pages of the service."""

from __future__ import annotations

import hashlib
import posixpath
import re
import unicodedata
from collections.abc import Sequence
from functools import cache
from pathlib import Path

from fastapi import APIRouter, Request, Response
from fastapi.responses import FileResponse
from markdown_it import MarkdownIt
from markdown_it.token import Token

import geoswarm
from geoswarm.api.errors import DetailError
from geoswarm.api.pages.shell import render

__all__ = ["CHAPTERS", "router"]

CHAPTERS = {
    "jobs": "index",
    "new": "quick-start#your-own-test",
    "compare": "report#other-weights",
    "workers": "agents",
    "job": "tutorials/reading-a-report",
    "fit": "statistics#whether-the-model-describes-the-data",
    "statistics": "statistics#verdicts",
    "search": "search",
    "data": "http-api",
    "mesh": "finite-elements",
    "sign_in": "security#access",
}
"""Page and heading that explain a view."""

_FOLDERS = ("", "laws", "tutorials")
_PICTURES = {".png": "image/png", ".svg": "image/svg+xml"}
_ELSEWHERE = re.compile(r"[a-z]+:|#")

router = APIRouter()


@router.get("/help")
@router.get("/help/{name:path}")
def help_page(request: Request, name: str = "index") -> Response:
    """Show a page of the documentation, or a picture of one."""
    name = name or "index"
    path = _files().get(name)
    if path is None:
        raise DetailError(404, "The documentation has no such page; /help is its first one.", title="Page not found")
    if path.suffix in _PICTURES:
        return FileResponse(path, media_type=_PICTURES[path.suffix])
    title, text = _read(name)
    return render(request, "help", title=title, text=text, first=name == "index")


@cache
def _files() -> dict[str, Path]:
    """Files by their address below /help: pages without their ending, a folder is its README."""
    package = Path(geoswarm.__file__).parent  # in a checkout the documentation is beside it
    folder = package / "docs" if (package / "docs").is_dir() else package.parent / "docs"
    found = {}
    for below in _FOLDERS:
        for path in (folder / below).glob("*.md"):
            found[below if path.stem == "README" else posixpath.join(below, path.stem)] = path
    pictures = (path for path in folder.rglob("*") if path.suffix in _PICTURES)
    return found | {path.relative_to(folder).as_posix(): path for path in pictures}


@cache
def _read(name: str) -> tuple[str, str]:
    """Title and HTML of a page."""
    markdown = MarkdownIt("commonmark").enable("table")
    tokens = markdown.parse(_files()[name].read_text(encoding="utf-8"))
    title, taken = name, dict[str, int]()
    for place, token in enumerate(tokens):
        if token.type == "heading_open":
            words = _words(tokens[place + 1].children or ())
            title = words if token.tag == "h1" else title
            token.attrSet("id", _anchor(words, taken))
        elif token.type == "fence" and token.info == "mermaid":
            # named as docs/draw_diagrams.py names it
            picture = f"/help/pictures/diagrams/{hashlib.sha256(token.content.encode()).hexdigest()[:12]}.svg"
            token.type, token.content = "html_block", f'<p><img src="{picture}" alt="Diagram"></p>'
        elif token.type in ("th_open", "td_open") and (style := token.attrs.pop("style", None)):
            token.attrs["class"] = "n" if style == "text-align:right" else ""  # the pages' policy allows no styles
        _point(token.children or [], name)
    return title, markdown.renderer.render(tokens, markdown.options, {})


def _words(tokens: Sequence[Token]) -> str:
    return "".join(token.content for token in tokens if token.type in ("text", "code_inline"))


def _anchor(words: str, taken: dict[str, int]) -> str:
    """The id of a heading, as the documentation's own links name it."""
    plain = unicodedata.normalize("NFKD", words).encode("ascii", "ignore").decode()
    name = re.sub(r"[-\s]+", "-", re.sub(r"[^\w\s-]", "", plain).strip().lower())
    taken[name] = taken.get(name, -1) + 1
    return f"{name}_{taken[name]}" if taken[name] else name


def _point(tokens: Sequence[Token], page: str) -> None:
    """Point links and pictures at their place below /help; a link to another file of the repository becomes text."""
    dropped = False
    for token in tokens:
        key = {"link_open": "href", "image": "src"}.get(token.type)
        if key is not None and not _ELSEWHERE.match(address := str(token.attrs[key])):
            link, hash_sign, heading = address.partition("#")
            folder = page if page in _FOLDERS else posixpath.dirname(page)
            target = posixpath.normpath(posixpath.join(folder, link)).removesuffix(".md").removesuffix("/README")
            if target in _files():
                token.attrs[key] = f"/help/{target}{hash_sign}{heading}"
            elif key == "href":
                token.type, token.content, dropped = "html_inline", "", True
        elif token.type == "link_close" and dropped:
            token.type, token.content, dropped = "html_inline", "", False
