"""Install requirements/dev.txt, with its hashes, and then this checkout, editable, into the environment that runs this.

pip's configuration decides where packages come from. pip fetches uv, which is in the lock; uv installs the rest many
times faster and takes over what the configuration says of indexes, proxy and certificates. Where it says more than uv
can be told, or uv does not succeed, pip installs everything.

    FOLDER/bin/python scripts/install_locked.py
"""

from __future__ import annotations

import ast
import os
import re
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path

ROOT = Path(__file__).parents[1]
LOCK = ROOT / "requirements" / "dev.txt"
PIP = [sys.executable, "-m", "pip", "install", "--quiet", "--quiet", "--disable-pip-version-check", "--no-input"]
UV_VARIABLES = {  # where pip's setting goes, and what stands between several values there
    "index-url": (("UV_DEFAULT_INDEX",), ""),
    "extra-index-url": (("UV_INDEX",), " "),
    "find-links": (("UV_FIND_LINKS",), ","),
    "trusted-host": (("UV_INSECURE_HOST",), " "),
    "cert": (("SSL_CERT_FILE",), ""),
    "proxy": (("HTTP_PROXY", "HTTPS_PROXY"), ""),
}
OF_NO_CONCERN = {
    *(
        "break-system-packages",
        "cache-dir",
        "config-file",
        "default-timeout",
        "disable-pip-version-check",
        "no-cache-dir",
        "no-color",
    ),
    *("no-input", "no-warn-script-location", "prefer-binary", "progress-bar", "quiet", "require-virtualenv", "retries"),
    *("root-user-action", "timeout", "verbose"),
}


def main() -> None:
    """Do it; the exit code is that of the installer that failed."""
    text = LOCK.read_text(encoding="utf-8")
    variables = uv_environment(pip_settings())
    if variables is None or not (install_uv(text) and install_with_uv(variables)):
        subprocess.run([*PIP, "--require-hashes", "--requirement", str(LOCK)], check=True)
    subprocess.run([*PIP, "--no-deps", "--no-build-isolation", "--editable", str(ROOT)], check=True)


def pip_settings() -> dict[str, str]:
    """Return pip's settings from its files and the environment; what is said for ``install`` alone wins."""
    listed = subprocess.run([*PIP[:3], "config", "list"], check=True, capture_output=True, text=True).stdout
    found = re.findall(r"^(global|install|:env:)\.([\w-]+)=(.*)$", listed, flags=re.MULTILINE)
    order = ("global", "install", ":env:")
    return {name: ast.literal_eval(text) for _, name, text in sorted(found, key=lambda line: order.index(line[0]))}


def uv_environment(settings: Mapping[str, str]) -> dict[str, str] | None:
    """Return environment variables that tell uv the same as pip's settings; None where that cannot be said."""
    if unknown := set(settings) - set(UV_VARIABLES) - OF_NO_CONCERN:
        print(f"geoswarm: pip installs, as its setting {sorted(unknown)[0]} has no counterpart in uv")
        return None
    named = {
        variable: between.join(settings[name].split()) if between else settings[name]
        for name, (variables, between) in UV_VARIABLES.items()
        if name in settings
        for variable in variables
    }
    # Like pip, look for a version in every index; whatever comes must have a hash of the lock.
    said = {name: value for name, value in os.environ.items() if name.startswith("UV_")}
    return {"UV_INDEX_STRATEGY": "unsafe-best-match"} | named | said


def install_uv(lock: str) -> bool:
    """Fetch the locked uv with pip."""
    entry = re.search(r"^uv==(?:.*\\\n)*.*$", lock, flags=re.MULTILINE)
    if entry is None:
        return False
    with tempfile.TemporaryDirectory() as folder:
        only = Path(folder) / "uv.txt"
        only.write_text(entry[0], encoding="utf-8")
        return subprocess.run([*PIP, "--require-hashes", "--requirement", str(only)], check=False).returncode == 0


def install_with_uv(variables: Mapping[str, str]) -> bool:
    """Install the lock with uv."""
    command = [sys.executable, "-m", "uv", "pip", "install", "--quiet", "--python", sys.executable]
    ran = subprocess.run(
        [*command, "--require-hashes", "--requirement", str(LOCK)],
        check=False,
        env={**os.environ, **variables},
        capture_output=True,
        text=True,
    )
    if ran.returncode:
        print(f"geoswarm: pip installs, as uv could not: {ran.stderr.strip()}")
    return ran.returncode == 0


if __name__ == "__main__":
    main()
