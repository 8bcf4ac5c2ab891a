"""Install requirements/dev.txt, with its hashes, and then this checkout, editable, into the environment that runs this.

pip's configuration decides where packages come from. pip fetches uv, which is in the lock; uv installs the rest many
times faster, with pip's indexes, proxy and certificates. If the configuration has a setting without a counterpart in
uv, or constrains a package of the lock, or if uv fails, pip installs everything.

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
    variables = uv_environment(pip_settings(), text)
    if variables is None or not (install_uv(text) and install_with_uv(variables)):
        subprocess.run([*PIP, "--require-hashes", "--requirement", str(LOCK)], check=True)
    subprocess.run([*PIP, "--no-deps", "--no-build-isolation", "--editable", str(ROOT)], check=True)


def pip_settings() -> dict[str, str]:
    """Return pip's settings from its files and the environment; what is said for ``install`` alone wins."""
    listed = subprocess.run([*PIP[:3], "config", "list"], check=True, capture_output=True, text=True).stdout
    found = re.findall(r"^(global|install|:env:)\.([\w-]+)=(.*)$", listed, flags=re.MULTILINE)
    order = ("global", "install", ":env:")
    return {name: ast.literal_eval(text) for _, name, text in sorted(found, key=lambda line: order.index(line[0]))}


def uv_environment(settings: Mapping[str, str], lock: str) -> dict[str, str] | None:
    """Return the environment variables of uv for pip's settings, or None if there is a setting that uv has not."""
    reason = None
    if unknown := set(settings) - set(UV_VARIABLES) - OF_NO_CONCERN - {"constraint"}:
        reason = f"its setting {sorted(unknown)[0]} has no counterpart in uv"
    elif bound := constrained(settings.get("constraint", ""), lock):
        reason = f"its setting constraint bounds {bound}, and uv takes no bounds together with hashes"
    if reason is not None:
        print(f"geoswarm: pip installs, as {reason}")
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


def constrained(files: str, lock: str) -> str | None:
    """Return what files of constraints bound in the lock, or what cannot be read of them; None if it is nothing."""
    locked = {normal(name) for name in re.findall(r"^([\w.-]+)==", lock, flags=re.MULTILINE)}
    for file in files.split():
        try:
            lines = Path(file).read_text(encoding="utf-8").splitlines()
        except (OSError, UnicodeError):  # perhaps an address
            return file
        for line in filter(None, (re.sub(r"(^|\s)#.*", "", line).strip() for line in lines)):
            name = re.match(r"[A-Za-z0-9][\w.-]*", line)
            if name is None or "://" in line or normal(name[0]) in locked:
                return line
    return None


def normal(name: str) -> str:
    """Return the name of a package as indexes write it."""
    return re.sub(r"[-_.]+", "-", name).lower()


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
