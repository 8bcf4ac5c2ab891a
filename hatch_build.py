"""Build hook: says what is wrong where the links of the repository are not links.

The rooms ``api``, ``workers`` and ``solver`` and the ``examples`` lie at the top of the repository and are linked into
``geoswarm``. Git writes a link as a small text file where it may not make links (Windows without the right to make
them, some network drives); a wheel built from that would be empty.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

LINKED = ("api", "examples", "solver", "workers")
SHOWN = (".md", ".png", ".svg")
LEFT_OUT = ("decisions", "reference", "verification")  # of the documentation that the service shows


class LinksHook(BuildHookInterface[Any]):
    """Stops a build, also an editable one, whose packages are missing."""

    PLUGIN_NAME = "custom"

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Look before the first file is taken up; ends the build with a message. Adds the documentation to a wheel."""
        missing = [f"geoswarm/{name}" for name in LINKED if not (Path(self.root) / "geoswarm" / name).is_dir()]
        if missing:
            raise SystemExit(
                f"geoswarm: {', '.join(missing)} must be links to the folders beside geoswarm/, and are none here: the "
                "file system, or git's settings, allow no links. Install the wheel or the source archive (pip install "
                "geoswarm), or clone again where links work: git clone -c core.symlinks=true (on Windows in developer "
                "mode, or in WSL)"
            )
        if version == "standard" and self.target_name == "wheel":
            docs = Path(self.root) / "docs"
            if not (docs / "index.md").is_file():
                raise SystemExit("geoswarm: the folder docs is missing; the service shows it. Copy it beside geoswarm/")
            for path in docs.rglob("*"):
                below = path.relative_to(docs)
                if path.suffix in SHOWN and below.parts[0] not in LEFT_OUT:
                    build_data["force_include"][str(path)] = f"geoswarm/docs/{below.as_posix()}"
