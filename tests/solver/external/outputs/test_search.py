"""Regular expressions: points of matches, and named values."""

from __future__ import annotations

from pathlib import Path

from tests.solver.external.outputs.reading import assert_bad, series

LOG = "step 1\nt = 0.5 uy = -1.5D-3 m\nFoS = 1.9\nt = 1.0 uy = -2.5D-3 m\nFoS = 1,5\nFoS = 1.4 (final), head 12.5\n"


def test_every_match_is_a_point(tmp_path: Path) -> None:
    find = r"t = (?P<x>\S+) uy = (?P<y>\S+)"
    assert series(tmp_path, LOG, find=find, y_factor=-1000.0) == [(0.5, 1.5), (1.0, 2.5)]
    assert series(tmp_path, "1:2 3:4\n", find=r"(?P<x>\d):(?P<y>\d)") == [(1.0, 2.0), (3.0, 4.0)]


def test_named_values_have_the_x_of_their_observation(tmp_path: Path) -> None:
    log = LOG.replace("1,5", "1.5")
    find = [r"FoS = (?P<fos>\S+)", r"head (?P<head>\S+)"]
    observed = {"head": 20.0, "fos": 1.0}
    assert series(tmp_path, log, find=find, observations=observed, take="last") == [(20.0, 12.5), (1.0, 1.4)]
    assert series(tmp_path, log, find=find, observations=observed, take="first") == [(20.0, 12.5), (1.0, 1.9)]
    message = "line 5: fos was found in line 3 already; write take: first or last"
    assert_bad(tmp_path, log, message, find=find, observations=observed)


def test_mistakes_name_line_and_group(tmp_path: Path) -> None:
    assert_bad(tmp_path, LOG, "out.txt: no line matches find: head (?P<x>a)", find="head (?P<x>a)(?P<y>b)")
    message = "out.txt: line 5: group fos: '1,5' has a comma"
    assert_bad(tmp_path, LOG, message, find=r"FoS = (?P<fos>\S+)", observations={"fos": 1.0}, take="last")
    assert_bad(tmp_path, "t = ** uy = 1", "line 1: group x: '**'", find=r"t = (?P<x>\S+) uy = (?P<y>\S+)")
    message = "no line matches find with a value for fos"
    assert_bad(tmp_path, "nothing\n", message, find=r"FoS = (?P<fos>\S+)", observations={"fos": 1.0})
