"""E-mail through the operator's server."""

from __future__ import annotations

import re
import smtplib
import ssl
from email.message import EmailMessage
from email.utils import formatdate

from geoswarm.workers.errors import HookRefusedError
from geoswarm.workers.notices.settings import NoticeSettings
from geoswarm.workers.notices.web import NotDeliveredError

__all__ = ["judge_address", "send_mail"]

ADDRESS = re.compile(r"[A-Za-z0-9.!#$%&'*+/=?^_`{|}~-]{1,64}@(?P<domain>[A-Za-z0-9-]{1,63}(\.[A-Za-z0-9-]{1,63})+)")
LONGEST = 254
REFUSED_FOR_GOOD = 550  # 550 and above: no such mailbox, not allowed


def judge_address(address: str, settings: NoticeSettings) -> None:
    """Make sure that messages may go to an address.

    Raises
    ------
    HookRefusedError
    """
    if settings.smtp_host is None:
        raise HookRefusedError("target", "this service sends no e-mail (its operator has set no GEOSWARM_SMTP_HOST)")
    match = ADDRESS.fullmatch(address)
    if match is None or len(address) > LONGEST:
        raise HookRefusedError("target", f"must be one address like anna@example.org, got {address[:80]!r}")
    if not settings.takes_mail_to(match["domain"]):
        raise HookRefusedError(
            "target", f"this service sends no e-mail to {match['domain']} (its operator chooses GEOSWARM_MAIL_DOMAINS)"
        )


def send_mail(settings: NoticeSettings, address: str, message_id: str, subject: str, text: str) -> None:
    """Hand one message to the server.

    Raises
    ------
    NotDeliveredError
    """
    if settings.smtp_host is None or settings.mail_from is None:
        raise NotDeliveredError("this service no longer sends e-mail (GEOSWARM_SMTP_HOST is not set)")
    message = EmailMessage()
    message["From"], message["To"] = settings.mail_from, address
    message["Subject"] = " ".join(subject.split())
    message["Date"] = formatdate()
    message["Message-ID"] = f"<{message_id}@{settings.mail_from.rpartition('@')[2]}>"
    message["Auto-Submitted"] = "auto-generated"  # RFC 3834: nobody's holiday answers this
    message.set_content(text)
    context = ssl.create_default_context()
    try:
        with _connected(settings, settings.smtp_host, context) as server:
            if settings.smtp_security == "starttls":
                server.starttls(context=context)
            if settings.smtp_user is not None and settings.smtp_password is not None:
                server.login(settings.smtp_user, settings.smtp_password.get_secret_value())
            server.send_message(message)
    except smtplib.SMTPRecipientsRefused as error:
        code, answer = next(iter(error.recipients.values()))
        raise NotDeliveredError(f"refused: {code} {_text(answer)}", final=code >= REFUSED_FOR_GOOD) from None
    except smtplib.SMTPResponseException as error:
        raise NotDeliveredError(f"refused: {error.smtp_code} {_text(error.smtp_error)}") from None
    except (smtplib.SMTPException, OSError) as error:
        raise NotDeliveredError(f"e-mail server: {error}") from None


def _connected(settings: NoticeSettings, host: str, context: ssl.SSLContext) -> smtplib.SMTP:
    if settings.smtp_security == "tls":
        return smtplib.SMTP_SSL(host, settings.port, timeout=settings.hook_seconds, context=context)
    return smtplib.SMTP(host, settings.port, timeout=settings.hook_seconds)


def _text(answer: bytes | str) -> str:
    return " ".join((answer.decode(errors="replace") if isinstance(answer, bytes) else answer).split())[:200]
