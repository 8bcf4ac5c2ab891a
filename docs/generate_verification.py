"""Writes the pages of the verification manual by running all its cases: about a minute.

Run ``python docs/generate_verification.py`` after a change of a case, and before a release. A test compares the pages
with what the cases declare, without their numbers, which are those of the machine that ran them.
"""

from __future__ import annotations

import sys
from pathlib import Path

from geoswarm.verification.catalogue import find_cases
from geoswarm.verification.pages import write_markdown
from geoswarm.verification.provenance import provenance
from geoswarm.verification.results import summary
from geoswarm.verification.run import run_cases

FOLDER = Path(__file__).parent / "verification"


def main() -> int:
    """Run the cases and write the pages; 1 where one does not hold."""
    outcomes = list(run_cases(find_cases()))
    print(summary(outcomes))
    wrong = [one.case.name for one in outcomes if one.state != "holds"]
    if wrong:
        print(f"not written, as these do not hold: {', '.join(wrong)}")
        return 1
    for old in (*FOLDER.glob("*.md"), *FOLDER.glob("figures/*.svg")):
        old.unlink()
    write_markdown(outcomes, provenance(machine="a machine of two cores"), FOLDER)
    return 0


if __name__ == "__main__":
    sys.exit(main())
