"""Values that no message may show."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from geoswarm.solver.external.runs.secrets import HIDDEN, Secrets, private_values


def test_long_values_are_hidden_anywhere_and_short_ones_as_words() -> None:
    secrets = Secrets(["rosebud", "x7", "4"])
    assert secrets.hidden("key=rosebud2 x7 'x7' x71 4 14 4.5 (4)") == "key=***2 *** '***' x71 *** 14 ***.5 (***)"


def test_private_values_are_hidden_as_words_whatever_their_length() -> None:
    secrets = Secrets([], ["deck", "1"])
    assert secrets.hidden("deck decks deck.inp 1 11 /deck/") == "*** decks ***.inp *** 11 /***/"


def test_a_value_of_several_lines_is_hidden_line_by_line() -> None:
    secrets = Secrets(["-----\nabc def\nq\n"])
    assert secrets.hidden("found abc def at q, -----\nabc def\nq\n.") == f"found {HIDDEN} at {HIDDEN}, {HIDDEN}\n."


def test_the_longest_value_counts() -> None:
    assert Secrets(["abc", "abcdef"]).hidden("abcdefabc") == HIDDEN * 2


def test_words_of_ours_stay() -> None:
    secrets = Secrets(["1"])
    own = "ended with exit status 1"
    assert secrets.hidden(f"ccx {own}, but 1 is not in it", own) == f"ccx {own}, but *** is not in it"


def test_without_values_a_text_is_as_it_was() -> None:
    assert Secrets(["", " \n"]).hidden("a  b") == "a  b"


def test_variables_that_any_program_sees_are_not_private_nor_is_what_a_user_chose() -> None:
    written = {"OMP_NUM_THREADS": "1", "LC_ALL": "C", "PORT": "50{slot}", "STEPS": "{steps}", "LICENCE": "27000@host"}
    given = written | {"PORT": "500", "STEPS": "5"}
    assert private_values(written, given) == ["500", "27000@host"]


@given(st.lists(st.text(min_size=1, max_size=6), max_size=4), st.text(max_size=40))
def test_no_long_value_is_left(values: list[str], text: str) -> None:
    found = Secrets(values).hidden(text)
    left = found.split(HIDDEN)
    longest = [value.strip() for value in values if len(value.strip()) > 2]
    assert not any(value in piece for value in longest for piece in left)
