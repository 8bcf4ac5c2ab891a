"""The figures of a run (matplotlib, without a display and its global state)."""
