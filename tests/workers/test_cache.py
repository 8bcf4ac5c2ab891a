"""What was made lately is kept, and made once."""

from __future__ import annotations

import gc
import threading
import weakref
from functools import partial

import pytest

from geoswarm.workers.cache import Cache


def test_the_latest_are_kept() -> None:
    cache = Cache(2)
    made: list[str] = []

    def make(key: str) -> str:
        made.append(key)
        return key

    for key in ("a", "b", "a", "c", "a", "b"):
        assert cache.once(key, partial(make, key)) == key
    assert made == ["a", "b", "c", "b"]


def test_one_makes_while_others_wait_and_other_things_are_made_meanwhile() -> None:
    cache, began, go_on = Cache(), threading.Event(), threading.Event()
    made: list[int] = []
    found: list[int] = []

    def make() -> int:
        began.set()
        assert go_on.wait(200)
        made.append(1)
        return len(made)

    threads = [threading.Thread(target=lambda: found.append(cache.once("slow", make))) for _ in range(4)]
    for thread in threads:
        thread.start()
    assert began.wait(200)
    assert cache.once("quick", lambda: 7) == 7
    go_on.set()
    for thread in threads:
        thread.join(200)
    assert (made, found) == ([1], [1, 1, 1, 1])


@pytest.mark.slow
def test_what_failed_is_tried_again_and_leaves_nothing() -> None:
    class Key:
        pass

    cache, key = Cache(), Key()
    gone = weakref.ref(key)
    with pytest.raises(ZeroDivisionError):
        cache.once(key, lambda: 1 // 0)
    assert cache.once("other", lambda: 2) == 2
    del key
    gc.collect()
    assert gone() is None
