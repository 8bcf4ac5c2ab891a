from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from geoswarm.workers.store.codec import (
    clean_text,
    pack_array,
    pack_json,
    pack_responses,
    text_of_program,
    unpack_array,
    unpack_json,
    unpack_responses,
)

FINITE = st.floats(allow_nan=False, allow_infinity=False)
CURVES = st.dictionaries(st.text(max_size=8), arrays(np.float64, st.integers(0, 200), elements=st.floats()), max_size=4)


def test_what_programs_write_cannot_steer_a_terminal_or_a_page() -> None:
    written = "red \x1b[31m\r\n10 %\r20 %\tthe \u202ednal\u202c\x00\n"
    assert text_of_program(written) == "red \\x1b[31m\n10 %\n20 %\tthe \\u202ednal\\u202c\n"


@given(st.lists(st.floats(allow_nan=False)))
def test_arrays_come_back_exactly(values: list[float]) -> None:
    array = np.array(values, dtype=np.float64)
    assert unpack_array(pack_array(array)).tobytes() == array.tobytes()


@given(CURVES)
def test_responses_come_back_exactly(responses: dict[str, np.ndarray]) -> None:
    back = unpack_responses(pack_responses(responses))
    assert list(back) == list(responses)
    assert all(back[name].tobytes() == values.tobytes() for name, values in responses.items())


def test_long_smooth_responses_are_deflated() -> None:
    responses = {"y": np.zeros(10_000)}
    assert len(pack_responses(responses)) < 1000
    assert unpack_responses(pack_responses(responses))["y"].tolist() == [0.0] * 10_000


@given(FINITE)
def test_floats_in_json_come_back_exactly(value: float) -> None:
    assert repr(unpack_json(pack_json(value))) == repr(value)


@pytest.mark.parametrize("value", [float("nan"), float("inf")])
def test_json_takes_no_nan_or_infinity(value: float) -> None:
    with pytest.raises(ValueError, match="JSON compliant"):
        pack_json({"objective": value})


def test_text_is_made_storable() -> None:
    assert clean_text("a\x00b\ud800c") == "ab?c"
