"""Figures of what comes next: predictions, and the worth of further tests."""
