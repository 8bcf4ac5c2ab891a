"""Write the synchronous client, geoswarm/client/_sync, from the asynchronous one, geoswarm/client/_async.

.venv/bin/python scripts/generate_client.py          (`make format` runs it)
.venv/bin/python scripts/generate_client.py --check  (`make check`) says what is out of date and changes nothing
"""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
WRITTEN = Path("geoswarm/client/_async")
GENERATED = Path("geoswarm/client/_sync")

# What the asynchronous client may use, and what becomes of it; in this order.
RULES = [
    (r"Lives in one event loop;", "Safe to use from several threads;"),
    (r"\ban ``async with``", "a ``with``"),
    (r"; the synchronous one is generated from it by ``[\w/.]+``\.", "."),
    (r"\basynchronous\b", "synchronous"),
    (r"\bawait asyncio\.to_thread\(([\w.]+)(?:, )?", r"\1("),
    (r"\basyncio\.sleep\b", "time.sleep"),
    (r"\bimport asyncio\b", "import time"),
    (r"\b(async|await) ", ""),
    (r"\bAsyncGenerator\[(\w+), None\]", r"Generator[\1, None, None]"),
    (r"\bAsync(?=[A-Z])", ""),
    (r"\b_async\b", "_sync"),
    (r"\ba(?=(close|closing|read)\b|iter_)", ""),
    (r"\b__a(?=(enter|exit)__)", "__"),
]
OURS = "--config=lint.isort.known-first-party=['geoswarm']"  # also while the generated folder is not there yet
LEFT = re.compile(r"\w*([Aa]sync|await)\w*|\b(__)?a(enter|exit|iter|next|close|closing|read)(__)?\b")


def main(arguments: list[str]) -> int:
    """Write the files, or with ``--check`` compare them; the exit code is 1 when they are not what they should be."""
    if arguments not in ([], ["--check"]):
        print(f"usage: generate_client.py [--check], not {' '.join(arguments)!r}", file=sys.stderr)
        return 2
    wanted = {GENERATED / path.name: generated(path) for path in sorted((ROOT / WRITTEN).glob("*.py"))}
    there = {path.relative_to(ROOT) for path in (ROOT / GENERATED).glob("*.py")}
    stale = [path for path, text in wanted.items() if path not in there or (ROOT / path).read_text("utf-8") != text]
    extra = sorted(there - set(wanted))
    if arguments:
        for path in stale:
            print(f"{path}: is not what scripts/generate_client.py makes of {WRITTEN / path.name}", file=sys.stderr)
        for path in extra:
            print(f"{path}: there is no {WRITTEN / path.name} that it could be made of", file=sys.stderr)
        if stale or extra:
            print(f"write changes into {WRITTEN} and run `make format`, which renews {GENERATED}", file=sys.stderr)
        return 1 if stale or extra else 0
    (ROOT / GENERATED).mkdir(exist_ok=True)
    for path in stale:
        (ROOT / path).write_text(wanted[path], encoding="utf-8")
    for path in extra:
        (ROOT / path).unlink()
    return 0


def generated(source: Path) -> str:
    """Return the synchronous form of a module, in the house's format."""
    text = source.read_text(encoding="utf-8")
    for pattern, replacement in RULES:
        text = re.sub(pattern, replacement, text)
    for number, line in enumerate(text.splitlines(), start=1):
        if found := LEFT.search(line):
            place = f"{source.relative_to(ROOT)}:{number}"
            raise SystemExit(f"{place}: no rule of scripts/generate_client.py says what becomes of {found[0]!r}")
    head = f"# Generated from {WRITTEN / source.name} by scripts/generate_client.py; `make format` renews it.\n"
    # Imports: in order, without those that are no longer used; a loop that only passes on becomes `yield from`.
    text = ruff(["check", "--fix", "--unsafe-fixes", "--select=I,F401,UP028", OURS], source.name, head + text)
    return ruff(["format"], source.name, text)


def ruff(command: list[str], name: str, text: str) -> str:
    """Run ruff over a text as if it stood in the generated folder."""
    call = [sys.executable, "-m", "ruff", *command, "--quiet", "--stdin-filename", str(GENERATED / name), "-"]
    done = subprocess.run(call, cwd=ROOT, input=text, capture_output=True, text=True, encoding="utf-8", check=False)
    if done.returncode:
        raise SystemExit(f"ruff cannot read what becomes of {WRITTEN / name}:\n{done.stderr or done.stdout}")
    return done.stdout


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
