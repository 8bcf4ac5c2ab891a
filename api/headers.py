"""Security headers of every answer."""

from __future__ import annotations

from starlette.datastructures import MutableHeaders

__all__ = ["ATTACHMENT_POLICY", "DOCUMENT_POLICY", "PLOT_POLICY", "add_security_headers"]

CONTENT_SECURITY_POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src 'self'; "
    "form-action 'none'; base-uri 'none'; frame-ancestors 'none'"
)

PLOT_POLICY = CONTENT_SECURITY_POLICY.replace("style-src 'self'", "style-src 'self' 'unsafe-inline'").replace(
    "img-src 'self' data:", "img-src 'self' data: blob:"
)
"""For pages with plots: Plotly writes style attributes."""

DOCUMENT_POLICY = (
    "default-src 'none'; style-src 'unsafe-inline'; img-src data:; form-action 'none'; base-uri 'none'; "
    "frame-ancestors 'none'"
)
"""For reports and figures, which carry their own style and need nothing else: no script runs in them."""

ATTACHMENT_POLICY = "sandbox; default-src 'none'; style-src 'unsafe-inline'; img-src 'self'; frame-ancestors 'none'"
"""For files that somebody has attached to a job: no origin, no script; a browser styles the image that it shows."""


def add_security_headers(headers: MutableHeaders) -> None:
    """Keep answers out of frames, caches and guesses about their type; pages load only what the service sends."""
    headers["X-Content-Type-Options"] = "nosniff"
    headers["X-Frame-Options"] = "DENY"
    headers["Referrer-Policy"] = "no-referrer"
    headers.setdefault("Content-Security-Policy", CONTENT_SECURITY_POLICY)
    headers.setdefault("Cache-Control", "no-store")
