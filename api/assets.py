"""Static files: read once, compressed once, cached permanently by browsers.

The address of a file holds the digest of all files (``/static/v-DIGEST/js/http.js``), so a browser never asks twice and
never mixes two versions; modules import each other by relative addresses and so stay under the digest of their page.
Without a digest, or with an old one, the present file comes with an ETag.

Plotly's JavaScript comes out of its Python wheel (:data:`PLOTLY`), not from here.
"""

from __future__ import annotations

import gzip
import hashlib
import json
import posixpath
import re
import threading
from dataclasses import dataclass, field
from importlib.util import find_spec
from pathlib import Path

from starlette.datastructures import Headers
from starlette.exceptions import HTTPException
from starlette.responses import Response
from starlette.types import Receive, Scope, Send

from geoswarm.solver.system.extras import needs_extra

__all__ = ["PLOTLY", "Assets"]

FOLDER = Path(__file__).with_name("static")
PLOTLY = "plotly.min.js"
MEDIA_TYPES = {
    ".css": "text/css; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
    ".json": "application/json",
    ".svg": "image/svg+xml",
}
IMPORTED = re.compile(r"""^(?:import|export)\b[^"']*["'](\.{1,2}/[^"']+)["']""", re.MULTILINE)
VERSIONED = re.compile(r"v-[0-9a-f]{16}/")
IMMUTABLE = "public, max-age=31536000, immutable"


@dataclass(eq=False, slots=True)
class _Asset:
    """A file with its compressed form, which is made when it is first needed."""

    body: bytes
    media_type: str
    _compressed: bytes | None = None
    _lock: threading.Lock = field(default_factory=threading.Lock)

    def compressed(self) -> bytes:
        with self._lock:
            if self._compressed is None:
                self._compressed = gzip.compress(self.body, 6, mtime=0)
            return self._compressed


class Assets:
    """ASGI application of the files below ``static`` and of Plotly."""

    def __init__(self) -> None:
        files = sorted(path for path in FOLDER.rglob("*") if path.suffix in MEDIA_TYPES)
        self._assets = {
            path.relative_to(FOLDER).as_posix(): _Asset(path.read_bytes(), MEDIA_TYPES[path.suffix]) for path in files
        }
        self.languages = {
            Path(name).stem: str(json.loads(asset.body)["name"])
            for name, asset in self._assets.items()
            if name.startswith("languages/")
        }
        plotly = _plotly()
        digest = hashlib.sha256(str(plotly.stat().st_size).encode())
        for name, asset in self._assets.items():
            digest.update(name.encode() + b"\0" + hashlib.sha256(asset.body).digest())
        self._modules: dict[str, tuple[str, ...]] = {}
        self._plotly = plotly
        self.version = digest.hexdigest()[:16]
        self._reading = threading.Lock()

    def modules(self, view: str) -> tuple[str, ...]:
        """Modules that the one of a view imports, also by others: a page that names them loads all of them at once."""
        if view not in self._modules:
            found: set[str] = set()
            self._follow(f"js/{view}.js", found)
            self._modules[view] = tuple(sorted(found))
        return self._modules[view]

    def _follow(self, name: str, found: set[str]) -> None:
        asset = self._assets.get(name)
        if asset is None:
            return
        for address in IMPORTED.findall(asset.body.decode()):
            imported = posixpath.normpath(posixpath.join(posixpath.dirname(name), address))
            if imported not in found:
                found.add(imported)
                self._follow(imported, found)

    @property
    def base(self) -> str:
        """Address of the folder in this version, without a slash at its end."""
        return f"/static/v-{self.version}"

    def prepare(self) -> None:
        """Read and compress what is large, so that the first page need not wait; may run in a thread."""
        self._asset(PLOTLY).compressed()

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request below ``/static``."""
        if scope["method"] not in ("GET", "HEAD"):
            raise HTTPException(405, headers={"Allow": "GET, HEAD"})
        await self._response(scope)(scope, receive, send)

    def _response(self, scope: Scope) -> Response:
        path = scope["path"].removeprefix(scope.get("root_path", "")).lstrip("/")
        match = VERSIONED.match(path)
        asset = self._asset(path[match.end() :] if match else path)
        headers = Headers(scope=scope)
        etag = f'"{self.version}"'
        current = match is not None and match[0] == f"v-{self.version}/"
        answer = {"ETag": etag, "Vary": "Accept-Encoding", "Cache-Control": IMMUTABLE if current else "no-cache"}
        if headers.get("if-none-match") == etag:
            return Response(status_code=304, headers=answer)
        if "gzip" in headers.get("accept-encoding", ""):
            return Response(
                asset.compressed(), headers=answer | {"Content-Encoding": "gzip"}, media_type=asset.media_type
            )
        return Response(asset.body, headers=answer, media_type=asset.media_type)

    def _asset(self, name: str) -> _Asset:
        if name == PLOTLY:
            with self._reading:
                if PLOTLY not in self._assets:
                    self._assets[PLOTLY] = _Asset(self._plotly.read_bytes(), MEDIA_TYPES[".js"])
        try:
            return self._assets[name]
        except KeyError:
            raise HTTPException(404) from None


def _plotly() -> Path:
    """Where the wheel keeps the JavaScript; importing the package itself would cost tenths of a second."""
    spec = find_spec("plotly")
    if spec is None or not spec.submodule_search_locations:
        raise ModuleNotFoundError(needs_extra("the dashboard", "plotly"), name="plotly")
    return Path(spec.submodule_search_locations[0]) / "package_data" / PLOTLY
