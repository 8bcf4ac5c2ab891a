"""Examples: problem files with their data; each is run and judged by ``tests/examples``."""
