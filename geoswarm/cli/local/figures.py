"""Whether reports and figures can be made here."""

from __future__ import annotations

__all__ = ["figures_missing"]

_PACKAGES = ("matplotlib", "jinja2", "reportlab")


def figures_missing(what: str) -> str | None:
    """Say which extra ``what`` needs for reports and figures; None when they can be made."""
    from geoswarm.solver.system.extras import has, needs_extra

    return next((needs_extra(what, package) for package in _PACKAGES if not has(package)), None)
