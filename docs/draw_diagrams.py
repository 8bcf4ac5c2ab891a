"""Draw the Mermaid diagrams of README and documentation as pictures for the site.

    python docs/draw_diagrams.py

Needs `npm`, which fetches Mermaid, and the browser of the tests. A picture is named after the text of its diagram:
pictures of diagrams that are gone are deleted.
"""

from __future__ import annotations

import subprocess
import sys
import tarfile
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from scripts.site_hooks import DOCS, MERMAID, diagram  # noqa: E402
from tests.dashboard.browser import chromium  # noqa: E402

PICTURES = DOCS / "pictures" / "diagrams"
MAJOR = "mermaid@11"
SCRIPT = "package/dist/mermaid.min.js"


def mermaid(folder: Path) -> str:
    """Return Mermaid as one script, fetched by npm."""
    subprocess.run(["npm", "pack", "--silent", MAJOR], cwd=folder, check=True, stdout=subprocess.DEVNULL)
    with tarfile.open(next(folder.glob("mermaid-*.tgz"))) as archive:
        found = archive.extractfile(SCRIPT)
        assert found is not None
        return found.read().decode()


def main() -> None:
    """Draw what has no picture yet."""
    sources = [text for path in [ROOT / "README.md", *DOCS.rglob("*.md")] for text in MERMAID.findall(path.read_text())]
    wanted = {diagram(source): source for source in sources}
    PICTURES.mkdir(parents=True, exist_ok=True)
    for path in PICTURES.glob("*.svg"):
        if path.name not in wanted:
            path.unlink()
    missing = {name: source for name, source in wanted.items() if not (PICTURES / name).exists()}
    if not missing:
        return
    with tempfile.TemporaryDirectory() as folder, chromium() as browser:
        page = browser.new_page()
        page.add_script_tag(content=mermaid(Path(folder)))
        page.evaluate("mermaid.initialize({theme: 'neutral', htmlLabels: false, flowchart: {htmlLabels: false}})")
        for name, source in missing.items():
            svg = page.evaluate("async source => (await mermaid.render('diagram', source)).svg", source)
            (PICTURES / name).write_text(svg + "\n", encoding="utf-8")
            print(f"drawn: {name}")


if __name__ == "__main__":
    main()
