"""Calculates settlement.fods with LibreOffice, which writes settlement.csv."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

CSV = "csv:Text - txt - csv (StarCalc):44,34,76,1,,1033,false,false"  # commas, UTF-8, English, all digits
here = Path.cwd()
call = [
    "soffice",
    f"-env:UserInstallation={(here / 'profile').as_uri()}",  # two LibreOffices at once need two profiles
    *("--headless", "--norestore", "--convert-to", CSV, "--outdir", str(here), "settlement.fods"),
]
try:
    done = subprocess.run(call, capture_output=True, text=True, check=False)
except FileNotFoundError:
    sys.exit("soffice was not found; install LibreOffice (Debian: libreoffice-calc), or put its folder on the PATH")
sys.stdout.write(done.stdout)
if not (here / "settlement.csv").exists():  # its exit status is 0 even where it could not read the sheet
    sys.exit(f"LibreOffice has written nothing: {done.stderr}")
if any(mark in (here / "settlement.csv").read_text(encoding="utf-8") for mark in ("Err:", "#")):
    sys.exit("ERROR IN A CELL of settlement.csv")
