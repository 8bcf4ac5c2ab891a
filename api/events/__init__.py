"""Events of jobs as they happen."""
