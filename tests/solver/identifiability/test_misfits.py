"""What is said of series that a model does not describe."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import get_args, get_type_hints

from geoswarm.records.remedy import Remedy as StoredRemedy
from geoswarm.solver.identifiability.misfits import Closeness, Misfit, sentence_of
from geoswarm.solver.identifiability.remedies import FollowUpKind, RemedyKind, follow_up, remedies_of
from tests.solver.problem.test_selection import staged

ROOT = Path(__file__).parents[3]
Q = Misfit("q", None, "pattern", 0.001, 8.1, -21.0, 0.1, None, "kPa", "%")
END = " The parameters are those of the closest curve, and their intervals do not hold."


def test_one_series() -> None:
    assert sentence_of([Q]) == (
        "The model does not describe q: it misses the readings by up to 21 kPa (calculated below measured, near 0.1 "
        "%), root mean square 8.1 kPa; noise has such a pattern with a probability below 0.2 %." + END
    )


def test_stages_of_one_series() -> None:
    stages = [replace(Q, stage=number, largest=float(number)) for number in (2, 3, 4, 7)]
    assert "it misses stages 2 to 4 and 7 by up to 7 kPa (calculated above measured, near 0.1 %); noise" in sentence_of(
        stages
    )


def test_each_of_several_series_is_named() -> None:
    u = replace(Q, series="u", deviation=3.0, largest=9.0)
    found = sentence_of([Q, u, *(replace(Q, series=name) for name in ("v", "w"))])
    assert found.startswith(
        "The model does not describe q, u, v and w. It misses q by up to 21 kPa (calculated below measured, near 0.1 "
        "%), root mean square 8.1 kPa; u by up to 9 kPa (calculated above measured, near 0.1 %), root mean square 3 "
        "kPa; v by"
    )
    assert "; and 1 other; of each, noise has such a pattern with a probability below 0.2 %." + END in found
    found = sentence_of([Q, replace(u, stage=5, reason="repeats")])
    assert "probability below 0.2 %; u in stage 5 by up to 9 kPa" in found
    assert "near 0.1 %); more than the scatter of repeats explains." in found


def test_many_series_are_said_by_quantity() -> None:
    many = [replace(Q, series=f"t{number}.q") for number in range(12)]
    close = [Closeness("q", 12, 21.0, 8.1, 0.04, "kPa"), Closeness("volumetric strain", 12, 0.3, 0.12, None, "%")]
    assert sentence_of(many, close, tests=12) == (
        "The model does not describe 12 series: noise has such a pattern with a probability below 0.2 %. Over all "
        "readings, q is met within 21 kPa (root mean square 8.1 kPa, peaks within 4 %) and volumetric strain is met "
        "within 0.3 % (root mean square 0.12 %). The parameters are those of the closest curve, and their intervals "
        "count each of the 12 tests as one piece of information."
    )


def test_stated_errors_are_told_together() -> None:
    one = replace(Q, reason="stated_error", ratio=2.9)
    assert sentence_of([one]) == (
        "The stated error is not met: the residuals of q (8.1 kPa) are 2.9 times as large, so intervals that rest on "
        "it are about as many times too narrow."
    )
    several = [replace(one, series=name) for name in ("q", "u", "v", "w", "x")]
    assert sentence_of(several) == (
        "Stated errors are not met: the residuals of q (8.1 kPa) are 2.9 times, of u (8.1 kPa) 2.9 times and of v "
        "(8.1 kPa) 2.9 times as large (2 more: see the table), so intervals that rest on them are about as many times "
        "too narrow."
    )
    assert sentence_of([one], tests=4).endswith(
        "2.9 times as large, so intervals count each of the 4 tests as one piece of information."
    )


def test_a_remedy_that_is_done_is_not_offered() -> None:
    missed = replace(Q, series="settlement")
    everything = remedies_of(staged(), [missed])
    assert [remedy.kind for remedy in everything] == ["stage_ends", "change_model", "thin"]
    assert everything[1].changes == ("x_from", "x_to", "leave_out_stages")
    done = remedies_of(staged(stage_x_from=30, x_to=1440), [missed])
    assert [remedy.kind for remedy in done] == ["change_model", "thin"]
    assert "(x_from, leave_out_stages)" in done[0].text
    reading = replace(Q, series="settlement", reason="gross_error", reading=3)
    assert remedies_of(staged(), [reading])[0].changes == ("gross_errors", "loss")
    assert remedies_of(staged(loss="soft_l1", error=0.1), [reading])[0].text == (
        "Look up reading 3 of settlement: correct a slip or leave it out as a gross error (gross_errors: [3])."
    )


def test_remedies_are_records_with_a_text() -> None:
    stated = replace(Q, series="settlement", reason="stated_error", ratio=3.0)
    (remedy,) = remedies_of(staged(error=0.1), [stated])
    assert remedy.to_json() == {
        "kind": "error",
        "series": None,
        "values": {},
        "changes": ["error"],
        "text": "State the error that the readings have, or leave 'error' out: it is then estimated.",
    }


def test_every_remedy_has_a_text_in_files_and_words_in_the_dashboard() -> None:
    kinds = get_args(RemedyKind)
    words = (ROOT / "api/static/js/remedies.js").read_text(encoding="utf-8")
    assert set(re.findall(r"^  (\w+): \(", words, re.MULTILINE)) == set(kinds)
    assert set(get_args(get_type_hints(StoredRemedy)["kind"])) == set(kinds)
    assert all(follow_up(kind).text.startswith(f"'geoswarm {kind}' ") for kind in get_args(FollowUpKind))
