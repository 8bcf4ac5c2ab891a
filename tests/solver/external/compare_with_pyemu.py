"""Write pyemu_cases.json: what pyEMU 1.7.0 reads and writes for the cases below, which our readers are compared with.

The script runs in an environment of its own.

    uv run --no-project --with pyemu==1.7.0 python tests/solver/external/compare_with_pyemu.py

A value of null says that pyEMU refuses the case: tabs and continued lines it does not know, nor Fortran's D exponents.
"""

from __future__ import annotations

import json
import tempfile
import warnings
from pathlib import Path
from typing import Any

CASES = Path(__file__).with_name("pyemu_cases.json")

LISTING = """\
 PROGRAM FLOW   run 1
 TIME STEP 1
  HEADS AT BORES
  bore    x       head
   1     10.0    1.23456E+01
   2     20.0   -7.5
   3    100.0    0.001

 TIME STEP 2
  HEADS AT BORES
  bore    x       head
   1     10.0    1.13456E+01
   2     20.0   -8.5
 BUDGET in=12.5 m3/d out= 11.25 m3/d error (%)= 0.5
a,b,c,1.5,2.5,3.5
"""

INSTRUCTIONS = {
    "line advance and words": "pif $\nl5 w w w !h1!\nl1 w w w !h2!\n",
    "words from a first column": "pif $\nl15 w w w !v1! !v2! w !v3!\n",
    "primary marker": "pif $\n$HEADS AT BORES$\nl2 !dum! !dum! !h1!\nl1 !dum! !x2! !h2!\n",
    "primary marker, again": "pif $\n$TIME STEP 2$\n$HEADS AT BORES$\nl2 w w w !h1!\n",
    "case of a marker": "pif $\n$heads at bores$\nl2 w w w !H1!\n",
    "secondary marker": "pif $\n$BUDGET$ $in=$ !qin!\n",
    "two secondary markers": "pif $\n$BUDGET$ $in=$ !qin! $out=$ !qout! $error (%)=$ !err!\n",
    "primary and secondary marker in tandem": "pif $\n$TIME STEP$ $2$\nl3 w w w !h1!\n",
    "another marker sign": "pif ~\n~BUDGET~ ~in=~ !q!\n",
    "fixed": "pif $\nl5 [n1]4:4 [x1]9:14 [h1]16:28\n",
    "semi-fixed": "pif $\nl5 (x1)8:12 (h1)18:20\n",
    "semi-fixed, inside a number": "pif $\nl5 (h1)20:22\n",
    "free": "pif $\nl5 !n1! !x1! !h1!\nl1 !n2! !x2! !h2!\n",
    "dummies": "pif $\nl5 !dum! !dum! !h1!\n",
    "whitespace behind a marker": "pif $\n$BUDGET$ w w w w !qout!\n",
    "long advance": "pif $\nl12 w !n1! w !x1! w !h1!\n",
    "tab": "pif $\nl5 t15 !h1!\n",
    "continuation": "pif $\nl5 !n1!\n& !x1! !h1!\n",
}

TEMPLATES = {
    "one space": ("ptf %\nk = %k1              %\n", {"k1": 1.23456789e-5}),
    "several spaces, one twice": ("ptf #\n#k1        # #n         #\n#K1            #\n", {"k1": 3.0, "n": 0.35}),
    "negative": ("ptf ~\n a ~psi       ~ b\n", {"psi": -12.5}),
    "large": ("ptf ~\n~E                 ~\n", {"e": 2.5e7}),
}


def read(instructions: str, folder: Path) -> dict[str, float] | None:
    """Return the values that pyEMU reads; None when it refuses."""
    from pyemu.pst.pst_utils import InstructionFile

    (folder / "case.ins").write_text(instructions, encoding="ascii")
    (folder / "case.out").write_text(LISTING, encoding="ascii")
    try:
        table = InstructionFile(str(folder / "case.ins")).read_output_file(str(folder / "case.out"))
    except Exception:  # noqa: BLE001  pyEMU raises nothing more precise
        return None
    return {str(name): float(value) for name, value in table["obsval"].items()}


def written(template: str, values: dict[str, float], folder: Path) -> str:
    """Return the file that pyEMU writes."""
    from pyemu.pst.pst_utils import write_to_template

    (folder / "case.tpl").write_text(template, encoding="ascii")
    write_to_template(values, str(folder / "case.tpl"), str(folder / "case.in"))
    return (folder / "case.in").read_text(encoding="ascii")


def main() -> None:
    """Run pyEMU on every case."""
    cases: dict[str, Any] = {"listing": LISTING}
    with tempfile.TemporaryDirectory() as name, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        folder = Path(name)
        cases["read"] = {
            case: {"instructions": text, "values": read(text, folder)} for case, text in INSTRUCTIONS.items()
        }
        cases["written"] = {
            case: {"template": text, "values": values, "text": written(text, values, folder)}
            for case, (text, values) in TEMPLATES.items()
        }
    CASES.write_text(json.dumps(cases, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
