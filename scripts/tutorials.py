"""Run the tutorials in docs/tutorials as a reader would, block by block, and keep the pictures that they make.

    python scripts/tutorials.py                     run all, and renew their pictures
    python scripts/tutorials.py first-oedometer     one of them

In a page, in its order:

- a block with a title (```yaml title="problem.yaml") is a file that the reader writes;
- ```bash is typed into a shell, ```python into one session of Python that lasts for the page;
- ```text below one of them is what it prints: `...` stands for anything, white space does not count, and
  other lines may come before and after;
- a picture below the comment `<!-- from: PATH -->` is that file of the reader's folder.
"""

from __future__ import annotations

import re
import shutil
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from scripts.blocks import blocks, printed_as_told  # noqa: E402
from scripts.reader import Reader, ReaderError  # noqa: E402

PAGES = ROOT / "docs" / "tutorials"
PICTURE = re.compile(r"<!-- from: (?P<source>\S+) -->\n!\[[^\]]+\]\((?P<target>[^)]+)\)")


def follow(path: Path, folder: Path, *, installed: bool = False) -> int:
    """Follow a page in an empty folder; return how many blocks were followed.

    Parameters
    ----------
    path, folder
        The page, and the reader's folder.
    installed
        With what is installed for this Python, in place of the sources beside this script.

    Raises
    ------
    ReaderError
        A block fails, prints something else than the page tells, or a picture is not made.
    """
    page = path.read_text(encoding="utf-8")
    printed: str | None = None
    followed = 0
    with Reader(folder, installed=installed) as reader:
        for block in blocks(page):
            where = f"{path.name}, line {block.line}"
            followed += 1
            if block.kind == "text" and block.title is None:
                if printed is None or not printed_as_told(block.text, printed):
                    raise ReaderError(f"{where}: the page tells\n{block.text}\nprinted is\n{printed}")
                continue
            try:
                printed = reader.do(block)
            except ReaderError as error:
                raise ReaderError(f"{where}: {error}") from None
        for match in PICTURE.finditer(page):
            if not (folder / match["source"]).is_file():
                raise ReaderError(f"{path.name}: {match['source']} was not made")
    return followed


def main() -> None:
    """Follow the pages named, or all, and copy their pictures beside them."""
    names = sys.argv[1:] or [path.stem for path in sorted(PAGES.glob("*.md")) if path.stem != "README"]
    for name in names:
        path = PAGES / f"{name}.md"
        with tempfile.TemporaryDirectory() as made:
            follow(path, Path(made))
            for match in PICTURE.finditer(path.read_text(encoding="utf-8")):
                target = PAGES / match["target"]
                target.parent.mkdir(exist_ok=True)
                shutil.copyfile(Path(made) / match["source"], target)
        print(f"{name}: done")


if __name__ == "__main__":
    main()
