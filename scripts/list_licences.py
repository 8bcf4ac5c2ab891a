"""Write THIRD-PARTY-LICENSES.md: the licence of every package of requirements/image.txt, from what is installed here.

.venv/bin/python scripts/list_licences.py
"""

from __future__ import annotations

import re
import sys
from collections.abc import Mapping
from importlib.metadata import PackageMetadata, PackageNotFoundError, metadata
from pathlib import Path

ROOT = Path(__file__).parents[1]
LOCK = ROOT / "requirements" / "image.txt"
LIST = ROOT / "THIRD-PARTY-LICENSES.md"

READ = {
    # Their metadata holds the whole text, a family ("BSD") or nothing: read in the licence file of each.
    **dict.fromkeys(("amqp", "billiard", "click-plugins", "contourpy", "cycler", "flexcache"), "BSD-3-Clause"),
    **dict.fromkeys(("jinja2", "kiwisolver", "pint", "prompt-toolkit", "reportlab", "scipy", "vine"), "BSD-3-Clause"),
    "matplotlib": "Matplotlib licence (based on PSF-2.0)",
    "meshio": "MIT",
    "numba": "BSD-2-Clause",
    "python-dateutil": "Apache-2.0 OR BSD-3-Clause",
}
CLASSIFIERS = {
    "Apache Software License": "Apache-2.0",
    "MIT License": "MIT",
    "Mozilla Public License 2.0 (MPL 2.0)": "MPL-2.0",
}
ELSEWHERE = {
    # Not installed on Linux with a current Python.
    "async-timeout": ("Apache-2.0", "https://github.com/aio-libs/async-timeout"),
    "tzdata": ("Apache-2.0", "https://github.com/python/tzdata"),
}
PAGES = ("homepage", "home", "source", "source code", "repository", "documentation")

HEAD = """\
# Third-party licences of the image

The image holds geoswarm (Apache-2.0, see LICENSE) and the packages below, each unchanged, as its project publishes
it. Their licence texts lie in the image beside them, in `/opt/geoswarm/lib/python*/site-packages/*.dist-info`. What
their compiled packages bring along (OpenBLAS and the run-time libraries of GCC in NumPy and SciPy, LLVM in llvmlite,
libpq, OpenSSL and Kerberos in psycopg-binary, image formats in Pillow) is named there, too. Python and Debian's
packages of the base image have theirs in `/usr/share/doc/*/copyright`. `make lock` writes this list.

**psycopg and psycopg-binary are under the LGPL 3.** They are used as a library: imported when geoswarm runs,
unchanged, not copied into its code, which stays under its own licence. Whoever hands the image on hands on copies of
psycopg: leave its licence texts in place, keep this notice, and pass on or point to its source (the address below;
the version is in `requirements/image.txt`). Nothing prevents a user from putting another version in its place: `pip
install` into `/opt/geoswarm` in an image built from this one, or another line in `requirements/image.txt`. certifi
and pathspec are under the MPL 2.0, which asks for the same of their own files only.

| package | licence | project |
|---|---|---|
"""


def main() -> None:
    """Write the list; the exit code is 1 when the licence of some package cannot be told."""
    rows = []
    unknown = []
    for name in locked_names(LOCK.read_text(encoding="utf-8")):
        licence, page = ELSEWHERE.get(name) or told(name)
        if licence is None or page is None:
            unknown.append(name)
        rows.append(f"| {name} | {licence} | {page} |\n")
    if unknown:
        sys.exit(f"licence or address of {', '.join(unknown)} is not known: look it up and add it to READ or ELSEWHERE")
    LIST.write_text(HEAD + "".join(rows), encoding="utf-8")


def locked_names(lock: str) -> list[str]:
    """Return the names of what a lock file pins, in order."""
    return re.findall(r"^([a-z0-9-]+)==", lock, flags=re.MULTILINE)


def told(name: str) -> tuple[str | None, str | None]:
    """Return licence and address of a package that is installed here; None for what its metadata do not tell."""
    try:
        found = metadata(name)
    except PackageNotFoundError:
        return None, None
    return READ.get(name) or licence_of(found), page_of(found)


def licence_of(found: PackageMetadata) -> str | None:
    """Return the licence as the metadata give it: an expression, a classifier, or one short line."""
    fields: Mapping[str, str] = found.json
    if "license_expression" in fields:
        return fields["license_expression"]
    classifiers = [line.rpartition(" :: ")[2] for line in found.get_all("Classifier") or ()]
    named = [CLASSIFIERS[line] for line in classifiers if line in CLASSIFIERS]
    if named:
        return " OR ".join(named)
    text = fields.get("license", "")
    return text if re.fullmatch(r"[A-Z][\w.]+(-[\w.]+)*", text) and text != "BSD" else None


def page_of(found: PackageMetadata) -> str | None:
    """Return the address of a project, its home page if it names one."""
    pages = {label.lower(): url for label, _, url in (p.partition(", ") for p in found.get_all("Project-URL") or ())}
    return found.json.get("home_page") or next((pages[label] for label in PAGES if label in pages), None)


if __name__ == "__main__":
    main()
