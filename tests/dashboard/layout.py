"""What a glance at a page would see, asked of the browser: nothing sticks out, no text on text, no empty plot."""

from __future__ import annotations

import time
from pathlib import Path

from playwright.sync_api import Page

__all__ = ["check_layout", "leaf_through"]

SHARED = 3
"""Pixels that two texts may share: boxes of letters are higher than the letters."""

FAULTS = Path(__file__).with_suffix(".js").read_text(encoding="utf-8")


def leaf_through(page: Page) -> None:
    """Scroll from top to bottom, so that what is drawn when it is looked at gets drawn, and back."""
    height: int = page.evaluate("document.documentElement.scrollHeight")
    size = page.viewport_size
    assert size is not None
    for y in range(0, height, size["height"] // 2):
        page.evaluate(
            "(y) => new Promise((done) => { scrollTo(0, y); requestAnimationFrame(() => setTimeout(done, 60)); })", y
        )
    page.evaluate("scrollTo(0, 0)")


def check_layout(page: Page, seconds: float = 20.0) -> None:
    """Nothing wider than the window, no text or control on another, no plot without traces or titles at its axes.

    What is still being drawn may take a while.
    """
    deadline = time.monotonic() + seconds
    while (faults := page.evaluate(FAULTS, SHARED)) and time.monotonic() < deadline:
        page.wait_for_timeout(300)
    assert faults == [], faults
