"""E-mail through a real server: encrypted, with a password, in plain words."""

from __future__ import annotations

import email.policy
import ssl
from collections.abc import Iterator
from contextlib import contextmanager
from email.message import EmailMessage
from email.parser import BytesParser
from pathlib import Path
from typing import Any

import pytest
from aiosmtpd.controller import Controller
from aiosmtpd.handlers import Message
from aiosmtpd.smtp import AuthResult, LoginPassword

from geoswarm.workers.access.principal import LOCAL
from geoswarm.workers.errors import HookRefusedError, SettingsError
from geoswarm.workers.notices.hooks import Hooks
from geoswarm.workers.notices.mail import send_mail
from geoswarm.workers.notices.notifier import Notifier
from geoswarm.workers.notices.settings import NoticeSettings
from geoswarm.workers.notices.verdicts import Found
from geoswarm.workers.notices.web import NotDeliveredError
from geoswarm.workers.service.job_service import JobService
from geoswarm.workers.settings import Settings
from geoswarm.workers.store import Store
from tests.servers import free_port
from tests.workers.conftest import ON_SQLITE, MakeWorker
from tests.workers.problems import line


class Box(Message):
    """Remembers what was sent; knows no mailbox of ``nobody``."""

    def __init__(self) -> None:
        super().__init__()
        self.messages: list[EmailMessage] = []

    async def handle_RCPT(self, _server: Any, _session: Any, envelope: Any, address: str, _options: Any) -> str:
        if address.startswith("nobody@"):
            return "550 no such mailbox"
        if address.startswith("later@"):
            return "451 come again later"
        envelope.rcpt_tos.append(address)
        return "250 OK"

    def prepare_message(self, _session: Any, envelope: Any) -> EmailMessage:
        parsed = BytesParser(policy=email.policy.default).parsebytes(envelope.content)
        assert isinstance(parsed, EmailMessage)
        parsed["X-Rcpt"] = ",".join(envelope.rcpt_tos)
        return parsed

    def handle_message(self, message: Any) -> None:
        self.messages.append(message)


def login(_server: Any, _session: Any, _envelope: Any, _mechanism: str, data: Any) -> AuthResult:
    good = isinstance(data, LoginPassword) and (data.login, data.password) == (b"robot", b"right")
    return AuthResult(success=good, handled=False)


@contextmanager
def mail_server(**options: Any) -> Iterator[tuple[Box, int]]:
    box = Box()
    controller = Controller(box, hostname="127.0.0.1", port=free_port(), **options)
    controller.start()
    try:
        yield box, controller.port
    finally:
        controller.stop()


@pytest.fixture
def trusted(certificate: tuple[Path, Path], monkeypatch: pytest.MonkeyPatch) -> ssl.SSLContext:
    """What a server shows; it is trusted here."""
    monkeypatch.setenv("SSL_CERT_FILE", str(certificate[0]))
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.load_cert_chain(*certificate)
    return context


def given(port: int, **changes: Any) -> NoticeSettings:
    values = {"smtp_host": "localhost", "smtp_port": port, "mail_from": "geoswarm@example.org"} | changes
    return NoticeSettings(**values, public_url="https://geoswarm.example.org/")


def test_a_finished_job_is_told_in_plain_words(
    store: Store, settings: Settings, service: JobService, make_worker: MakeWorker
) -> None:
    found = Found("mm²", "The model describes the data.", {"a": "identified", "b": "undecided"})
    with mail_server() as (box, port):
        notices = given(port, smtp_security="none")
        made = Hooks(store, LOCAL, notices).create("anna@example.org")
        assert (made.secret, made.view.kind) == (None, "mail")
        job, _ = service.submit(line(name="Köln", stopping={"max_evaluations": 24}))
        worker = make_worker()
        worker.start()
        worker.serve(job.id)
        worker.close()
        assert Notifier(store, settings, notices, find=lambda _settings, _job: found).deliver() == 1
    (message,) = box.messages
    assert message["subject"] == "geoswarm: Köln has finished"
    assert (message["to"], message["x-rcpt"]) == ("anna@example.org", "anna@example.org")
    assert message["from"] == "geoswarm@example.org"
    assert message["auto-submitted"] == "auto-generated"
    text = message.get_content().replace("\r\n", "\n")
    ended = service.get(job.id)
    assert 'The job "Köln" has finished after' in text
    assert "24 evaluations in 4 generations." in text
    assert "Ended because: maximum number of evaluations reached." in text
    assert f"Best objective: {ended.objective:.4g} mm²\nThe model describes the data.\n" in text
    assert ended.parameters is not None
    assert f"  a = {ended.parameters['a']:.5g}  (identified)\n" in text
    assert f"  b = {ended.parameters['b']:.5g}  (undecided)\n" in text
    assert f"https://geoswarm.example.org/jobs/{job.id}" in text


def test_a_name_cannot_add_headers() -> None:
    with mail_server() as (box, port):
        subject = "geoswarm: x\r\nBcc: eve@example.org\r\n\r\nbody"
        send_mail(given(port, smtp_security="none"), "anna@example.org", "m-1", subject, "Text\n.\nmore\n")
    (message,) = box.messages
    assert message["subject"] == "geoswarm: x Bcc: eve@example.org body"
    assert (message["bcc"], message["x-rcpt"]) == (None, "anna@example.org")
    assert message.get_content().splitlines() == ["Text", ".", "more"]


def test_it_is_encrypted_and_asks_for_the_password(trusted: ssl.SSLContext) -> None:
    with mail_server(tls_context=trusted, require_starttls=True, authenticator=login, auth_required=True) as (
        box,
        port,
    ):
        settings = given(port, smtp_user="robot", smtp_password="right")
        send_mail(settings, "anna@example.org", "m-1", "Subject", "Text\n")
        with pytest.raises(NotDeliveredError, match="refused: 535"):
            send_mail(given(port, smtp_user="robot", smtp_password="wrong"), "anna@example.org", "m-2", "S", "T")
        with pytest.raises(NotDeliveredError, match="refused: 530"):
            send_mail(given(port, smtp_security="none"), "anna@example.org", "m-3", "S", "T")
    assert [message["message-id"] for message in box.messages] == ["<m-1@example.org>"]


def test_a_server_that_is_encrypted_from_the_first_byte(trusted: ssl.SSLContext) -> None:
    with mail_server(ssl_context=trusted) as (box, port):
        send_mail(given(port, smtp_security="tls"), "anna@example.org", "m-1", "Subject", "Text\n")
    assert len(box.messages) == 1


def test_a_certificate_that_nobody_knows_is_refused(certificate: tuple[Path, Path]) -> None:
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.load_cert_chain(*certificate)
    with (
        mail_server(tls_context=context) as (box, port),
        pytest.raises(NotDeliveredError, match="certificate verify failed"),
    ):
        send_mail(given(port), "anna@example.org", "m-1", "Subject", "Text\n")
    assert box.messages == []


@pytest.mark.parametrize(("address", "final"), [("nobody@example.org", True), ("later@example.org", False)])
def test_whom_the_server_does_not_know_is_given_up(address: str, final: bool) -> None:
    with mail_server() as (_box, port), pytest.raises(NotDeliveredError, match="refused: ") as raised:
        send_mail(given(port, smtp_security="none"), address, "m-1", "Subject", "Text\n")
    assert raised.value.final is final


def test_a_server_that_is_down_is_reported() -> None:
    with pytest.raises(NotDeliveredError, match=r"e-mail server: .*refused"):
        send_mail(given(free_port(), smtp_security="none"), "anna@example.org", "m-1", "Subject", "Text\n")


@ON_SQLITE
@pytest.mark.parametrize(
    ("address", "words"),
    [
        ("anna@elsewhere.org", "sends no e-mail to elsewhere.org"),
        ("anna@example.org,eve@example.org", "one address like anna@example.org"),
        ("anna@example", "one address like anna@example.org"),
        ("anna@example.org\nBcc: eve@example.org", "one address like"),
        ("Anna <anna@example.org>", "one address like"),
    ],
)
def test_mistakes_in_an_address_are_named(store: Store, address: str, words: str) -> None:
    with pytest.raises(HookRefusedError, match=words):
        Hooks(store, LOCAL, given(25)).create(address)


@ON_SQLITE
def test_without_a_server_no_e_mail_is_promised(store: Store) -> None:
    with pytest.raises(HookRefusedError, match="sends no e-mail"):
        Hooks(store, LOCAL, NoticeSettings()).create("anna@example.org")


def test_an_operator_chooses_the_domains() -> None:
    assert given(25, mail_domains="example.com, Example.NET").takes_mail_to("example.net")
    assert not given(25, mail_domains="example.com").takes_mail_to("example.org")
    assert given(25, mail_domains="*").takes_mail_to("anything.org")


@pytest.mark.parametrize(
    ("variables", "words"),
    [
        ({"GEOSWARM_PUBLIC_URL": "geoswarm.example.org"}, "GEOSWARM_PUBLIC_URL must be the address of the dashboard"),
        (
            {"GEOSWARM_HOOK_NETWORKS": "10.0.0.1/8"},
            "GEOSWARM_HOOK_NETWORKS must hold networks: '10.0.0.1/8' is not one",
        ),
        ({"GEOSWARM_SMTP_HOST": "mail.example.org"}, "GEOSWARM_MAIL_FROM must be the sender's address"),
        (
            {"GEOSWARM_SMTP_HOST": "m", "GEOSWARM_MAIL_FROM": "a@b.org", "GEOSWARM_SMTP_USER": "robot"},
            "GEOSWARM_SMTP_USER and GEOSWARM_SMTP_PASSWORD",
        ),
        (
            {
                "GEOSWARM_SMTP_HOST": "mail.example.org",
                "GEOSWARM_MAIL_FROM": "a@b.org",
                "GEOSWARM_SMTP_USER": "robot",
                "GEOSWARM_SMTP_PASSWORD": "very-secret",
                "GEOSWARM_SMTP_SECURITY": "none",
            },
            "GEOSWARM_SMTP_SECURITY must be starttls or tls",
        ),
        ({"GEOSWARM_SMTP_PORT": "70000"}, "GEOSWARM_SMTP_PORT '70000': Input should be less than or equal to 65535"),
    ],
)
def test_mistakes_of_an_operator_are_named(
    monkeypatch: pytest.MonkeyPatch, variables: dict[str, str], words: str
) -> None:
    for name, value in variables.items():
        monkeypatch.setenv(name, value)
    with pytest.raises(SettingsError) as raised:
        NoticeSettings.from_environment()
    assert words in str(raised.value)
    assert "very-secret" not in str(raised.value)


def test_the_password_comes_from_a_file_too(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    (tmp_path / "password").write_text("right\n")
    monkeypatch.setenv("GEOSWARM_SMTP_PASSWORD_FILE", str(tmp_path / "password"))
    found = NoticeSettings.from_environment().smtp_password
    assert found is not None
    assert found.get_secret_value() == "right"
