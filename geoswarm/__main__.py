"""``python -m geoswarm`` is the command line."""

from __future__ import annotations

import sys

from geoswarm.cli import main

if __name__ == "__main__":
    sys.exit(main())
