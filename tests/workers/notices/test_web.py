"""Requests are signed as the standard says, go where they may go only, and end in time."""

from __future__ import annotations

import base64
import ipaddress
import re
import socket
import ssl
import subprocess
import threading
import time
from pathlib import Path
from typing import Any

import pytest

from geoswarm.workers.errors import HookRefusedError
from geoswarm.workers.notices import web
from geoswarm.workers.notices.addresses import ForbiddenAddressError, judge_url, may_reach, resolve
from geoswarm.workers.notices.web import NotDeliveredError, new_secret, post, signature
from tests.servers import find_program
from tests.workers.notices.conftest import LOOPBACK, Receiver

NETWORKS = tuple(ipaddress.ip_network(text) for text in LOOPBACK)
FORBIDDEN = (
    *("127.0.0.1", "127.8.9.1", "0.0.0.0", "10.1.2.3", "172.16.0.1", "192.168.1.1", "169.254.169.254", "100.64.0.1"),
    *("192.0.0.8", "198.18.0.1", "224.0.0.1", "239.1.1.1", "240.0.0.1", "255.255.255.255"),
    *("::1", "::", "fe80::1", "fc00::1", "fd12::1", "ff02::1", "::ffff:10.0.0.1", "::ffff:127.0.0.1"),
    *("64:ff9b::a00:1", "2002:a00:1::", "2001:db8::1", "fec0::1"),
)
PUBLIC = ("93.184.216.34", "8.8.8.8", "2606:4700:4700::1111", "64:ff9b::808:808")


def test_the_signature_is_that_of_the_standard() -> None:
    """Of the specification's example, as its own Python library signs it."""
    signed = signature(
        "whsec_MfKQ9r8GKYqrTwjUPD8ILPZIo2LaLaSw",
        "msg_p5jXN8AQM9LWM0D4loKWxJek",
        1614265330,
        b'{"test": 2432232314}',
    )
    assert signed == "v1,g0hM9SsE+OTPJTGt/tmIKtSyZlE3uFJELVlNIOLJ1OE="


def test_the_signature_is_the_one_that_openssl_finds() -> None:
    secret = new_secret()
    key = base64.b64decode(secret.removeprefix("whsec_"))
    assert len(key) == 32
    body = '{"name": "Köln"}'.encode()
    found = subprocess.run(
        [str(find_program("openssl")), "dgst", "-sha256", "-mac", "HMAC", "-macopt", f"hexkey:{key.hex()}", "-binary"],
        input=b"message-1.1700000000." + body,
        capture_output=True,
        check=True,
    ).stdout
    assert signature(secret, "message-1", 1700000000, body) == f"v1,{base64.b64encode(found).decode()}"


@pytest.mark.parametrize("text", FORBIDDEN)
def test_addresses_that_only_the_services_network_reaches_are_refused(text: str) -> None:
    assert not may_reach(ipaddress.ip_address(text), ())
    host = f"[{text}]" if ":" in text else text
    with pytest.raises(HookRefusedError, match="not an address that this service may send requests to"):
        judge_url(f"https://{host}/hook", ())
    with pytest.raises(ForbiddenAddressError):
        resolve(text, 443, ())


@pytest.mark.parametrize("text", PUBLIC)
def test_public_addresses_are_reached_with_tls_only(text: str) -> None:
    assert may_reach(ipaddress.ip_address(text), ())
    assert not may_reach(ipaddress.ip_address(text), NETWORKS, encrypted=False)


@pytest.mark.parametrize("text", ["localhost", "2130706433", "0x7f.1", "017700000001", "127.1"])
def test_other_ways_to_write_an_address_are_judged_by_what_they_mean(text: str) -> None:
    with pytest.raises(ForbiddenAddressError):
        resolve(text, 443, ())
    with pytest.raises(NotDeliveredError, match="not an address that this service may send requests to"):
        post(f"https://{text}/", new_secret(), "m", b"{}", networks=(), seconds=5)


def test_a_network_of_the_operators_is_allowed_and_no_other() -> None:
    own = (ipaddress.ip_network("10.1.0.0/16"),)
    assert may_reach(ipaddress.ip_address("10.1.2.3"), own, encrypted=False)
    assert may_reach(ipaddress.ip_address("::ffff:10.1.2.3"), own)
    assert not may_reach(ipaddress.ip_address("10.2.2.3"), own)


@pytest.mark.parametrize(
    ("url", "words"),
    [
        ("http://example.org/", "like https://example.org/hook, got 'http://example.org/'"),
        ("ftp://example.org/", "like https://example.org/hook"),
        ("https:///hook", "like https://example.org/hook"),
        ("https://anna:word@example.org/", "no user name or password"),
        ("https://example.org:0/", "port must be 1 to 65535"),
        ("https://example.org:99999/", "is not an address"),
        ("https://[::1/", "is not an address"),
        ("https://exämple.org/", "printable ASCII"),
        ("https://example.org/\r\nX: y", "printable ASCII"),
        ("https://example.org/" + 500 * "a", "at most 500"),
    ],
)
def test_mistakes_in_an_address_are_named(url: str, words: str) -> None:
    with pytest.raises(HookRefusedError, match=re.escape(words)) as raised:
        judge_url(url, ())
    assert raised.value.field == "target"


def send(receiver: Receiver, **changes: Any) -> None:
    post(receiver.url, new_secret(), "message-1", b"{}", **({"networks": NETWORKS, "seconds": 20.0} | changes))


def test_a_message_arrives_with_its_headers(receiver: Receiver) -> None:
    secret = new_secret()
    post(receiver.url, secret, "message-1", b'{"a": 1}', networks=NETWORKS, seconds=20, now=lambda: 1700000000.7)
    assert receiver.bodies == [b'{"a": 1}']
    (headers,) = receiver.headers
    assert headers["webhook-id"] == "message-1"
    assert headers["webhook-timestamp"] == "1700000000"
    assert headers["webhook-signature"] == signature(secret, "message-1", 1700000000, b'{"a": 1}')
    assert headers["content-type"] == "application/json"


@pytest.mark.parametrize("status", [301, 302, 307, 308])
def test_redirections_are_not_followed(receiver: Receiver, status: int) -> None:
    receiver.statuses = [status]
    with pytest.raises(NotDeliveredError, match=f"status {status}"):
        send(receiver)
    assert receiver.paths == ["/hook"]


def test_a_receiver_that_is_gone_is_not_asked_again(receiver: Receiver) -> None:
    receiver.statuses = [410, 500]
    with pytest.raises(NotDeliveredError, match="gone") as gone:
        send(receiver)
    assert gone.value.final
    with pytest.raises(NotDeliveredError, match="status 500") as failed:
        send(receiver)
    assert not failed.value.final


def test_an_answer_that_drips_ends_at_the_deadline(receiver: Receiver) -> None:
    ended = threading.Event()

    def drip(handler: Any) -> None:
        try:
            for letter in "HTTP/1.1 200 OK\r\nX-Endless: " + 10_000 * "a":
                handler.wfile.write(letter.encode())
                handler.wfile.flush()
                time.sleep(0.05)
        except OSError:
            ended.set()

    receiver.answer = drip
    with pytest.raises(NotDeliveredError, match=r"no answer within 0\.5 s"):
        send(receiver, seconds=0.5)
    assert ended.wait(120.0), "the server still drips"


def test_an_answer_without_end_is_not_read_on(receiver: Receiver) -> None:
    def pour(handler: Any) -> None:
        handler.wfile.write(b"HTTP/1.1 200 OK\r\n\r\n")
        try:
            for _ in range(10_000):
                handler.wfile.write(65536 * b"a")
        except OSError:
            return

    receiver.answer = pour
    with pytest.raises(NotDeliveredError, match=f"longer than {web.MOST_BYTES} bytes"):
        send(receiver)


def test_the_address_that_was_judged_is_the_one_that_is_connected_to(
    receiver: Receiver, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A name may answer differently the second time: there is no second time."""
    real, asked = socket.getaddrinfo, []

    def answers(host: Any, port: Any, *rest: Any, **more: Any) -> Any:
        if host != "rebound.example":
            return real(host, port, *rest, **more)
        asked.append(host)
        return real("127.0.0.1" if len(asked) == 1 else "10.255.255.1", port, *rest, **more)

    monkeypatch.setattr(socket, "getaddrinfo", answers)
    send(Receiver(url=receiver.url.replace("127.0.0.1", "rebound.example")))
    assert asked == ["rebound.example"]
    assert receiver.headers[0]["host"].startswith("rebound.example:")
    with pytest.raises(NotDeliveredError, match=r"rebound\.example is not an address"):
        send(Receiver(url=receiver.url.replace("127.0.0.1", "rebound.example")))
    assert len(receiver.bodies) == 1


def test_one_forbidden_address_among_several_refuses_the_name(monkeypatch: pytest.MonkeyPatch) -> None:
    kind = (socket.AF_INET, socket.SOCK_STREAM, 6, "")
    mixed = [(*kind, ("93.184.216.34", 443)), (*kind, ("10.0.0.1", 443))]
    monkeypatch.setattr(socket, "getaddrinfo", lambda *_a, **_k: mixed)
    with pytest.raises(ForbiddenAddressError):
        resolve("mixed.example", 443, ())


def test_the_certificate_must_be_that_of_the_name(
    certificate: tuple[Path, Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.load_cert_chain(*certificate)
    with socket.create_server(("127.0.0.1", 0)) as listener:
        port = listener.getsockname()[1]
        heard: list[bytes] = []

        def serve() -> None:
            for _ in range(3):
                connection, _peer = listener.accept()
                try:
                    with context.wrap_socket(connection, server_side=True) as stream:
                        request = b""
                        while b"{}" not in request and (more := stream.recv(65536)):
                            request += more
                        heard.append(request)
                        stream.sendall(b"HTTP/1.1 200 OK\r\nContent-Length: 0\r\n\r\n")
                except OSError:  # the client did not like the certificate
                    continue

        thread = threading.Thread(target=serve)
        thread.start()

        def ask(host: str) -> None:
            post(f"https://{host}:{port}/hook", new_secret(), "m", b"{}", networks=NETWORKS, seconds=20)

        with pytest.raises(NotDeliveredError, match="certificate verify failed"):
            ask("localhost")
        monkeypatch.setenv("SSL_CERT_FILE", str(certificate[0]))
        ask("localhost")
        with pytest.raises(NotDeliveredError, match="certificate verify failed"):
            ask("127.0.0.1")
        thread.join()
    assert len(heard) == 1
