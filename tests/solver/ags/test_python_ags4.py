"""Our reader against the one of the format's owners, which has an environment of its own: its pins contradict ours."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

import pytest

from geoswarm.solver.ags.reading import read_ags
from tests.examples.engines import from_pypi
from tests.solver.ags.synthetic import content

# UNIT, TYPE and DATA rows of each group, without the name of the row
SCRIPT = """
import json, sys
from python_ags4 import AGS4
tables, _ = AGS4.AGS4_to_dataframe(sys.argv[1])
print(json.dumps({name: [list(frame.columns[1:]), frame.values[:, 1:].tolist()] for name, frame in tables.items()}))
"""


@pytest.mark.slow
def test_both_readers_find_the_same_cells(tmp_path: Path) -> None:
    path = tmp_path / "synthetic.ags"
    path.write_bytes(content())
    python = from_pypi("python-ags4==1.2.0") / "python"
    done = subprocess.run([python, "-c", SCRIPT, path], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    theirs = json.loads(done.stdout.splitlines()[-1])
    ours = {
        name: [list(group.headings), [list(group.units), list(group.types), *(list(row.cells) for row in group.rows)]]
        for name, group in read_ags(path.read_bytes(), path.name).groups.items()
    }
    assert ours == theirs
