"""The proxy that docs/agents.md shows, with a certificate of its own and ports of this machine."""

from __future__ import annotations

import subprocess
from pathlib import Path

from tests.documentation.pages import block
from tests.servers import find_program

__all__ = ["CERTIFICATE", "nginx_configuration"]

CERTIFICATE = "localhost.pem"
KEY = "localhost.key"
KINDS = ("client_body", "proxy", "fastcgi", "uwsgi", "scgi")


def nginx_configuration(folder: Path, port: int, target: int) -> str:
    """Make a certificate of ``localhost`` in a folder; return the page's server with these ports."""
    certificate, key = folder / CERTIFICATE, folder / KEY
    subprocess.run(
        [
            *(str(find_program("openssl")), "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "2"),
            *("-keyout", str(key), "-out", str(certificate)),
            *("-subj", "/CN=localhost", "-addext", "subjectAltName=DNS:localhost"),
        ],
        check=True,
        capture_output=True,
    )
    server = block("docs/agents.md", "proxy_pass").text
    for printed, own in {
        "listen 443 ssl": f"listen 127.0.0.1:{port} ssl",
        "server_name calibration.example.org": "server_name localhost",
        "/etc/ssl/calibration.pem": str(certificate),
        "/etc/ssl/private/calibration.key": str(key),
        "http://127.0.0.1:8765": f"http://127.0.0.1:{target}",
    }.items():
        assert printed in server, printed
        server = server.replace(printed, own)
    return (
        f"daemon off;\npid {folder}/nginx.pid;\nerror_log {folder}/nginx-error.log;\n"
        "events { worker_connections 256; }\nhttp {\naccess_log off;\n"
        + "".join(f"{kind}_temp_path {folder}/{kind};\n" for kind in KINDS)
        + f"{server}}}\n"
    )
