"""Files attached to jobs: what is accepted, limits and quotas, and that nothing is left of what is deleted."""

from __future__ import annotations

import contextlib
import hashlib
import io
import os
import sqlite3
import threading
import tracemalloc
import zipfile
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from functools import partial
from pathlib import Path

import pytest
from sqlalchemy import func, select

from geoswarm.records.job import Attachment
from geoswarm.workers.access.principal import Principal
from geoswarm.workers.errors import (
    AttachmentNotFoundError,
    AttachmentRefusedError,
    JobNotFoundError,
    QuotaExceededError,
    StoreUnavailableError,
)
from geoswarm.workers.operations.retention import delete_job
from geoswarm.workers.service import attachments as module
from geoswarm.workers.service.attachments import Attachments
from geoswarm.workers.service.job_service import JobService
from geoswarm.workers.service.media_types import PIECE_BYTES
from geoswarm.workers.store import Store
from geoswarm.workers.store.tables import attachment_pieces, attachments
from tests.integration.engines import PATIENCE
from tests.workers.conftest import ON_SQLITE
from tests.workers.problems import line

ALICE, BOB, ADMIN = Principal("alice", "submit", "a"), Principal("bob", "submit", "b"), Principal("root", "admin", "r")
PNG, JPEG, PDF = b"\x89PNG\r\n\x1a\n", b"\xff\xd8\xff\xe0", b"%PDF-1.7\n"
MB = 10**6


def photo(size: int = 1000, seed: bytes = b"") -> io.BytesIO:
    """A file that begins as a photo does, with other bytes for each seed."""
    return io.BytesIO((JPEG + seed).ljust(size, b"\x11"))


def limited(service: JobService, principal: Principal, **limits: float) -> JobService:
    bound = service.on_behalf_of(principal)
    bound.settings = service.settings.model_copy(update=limits)
    return bound


def rows(store: Store) -> tuple[int, int]:
    """Number of files and of pieces."""
    counts = [select(func.count()).select_from(table) for table in (attachments, attachment_pieces)]
    return store.read(lambda c: (c.scalar(counts[0]) or 0, c.scalar(counts[1]) or 0))


def workbook(*names: str) -> bytes:
    made = io.BytesIO()
    with zipfile.ZipFile(made, "w") as archive:
        for name in names:
            archive.writestr(name, "x")
    return made.getvalue()


def open_document() -> bytes:
    made = io.BytesIO()
    with zipfile.ZipFile(made, "w") as archive:
        archive.writestr("mimetype", "application/vnd.oasis.opendocument.spreadsheet")
    return made.getvalue()


def test_a_file_comes_back_as_it_was_sent(service: JobService) -> None:
    files = service.attachments
    job_id = service.submit(line())[0].id
    content = JPEG + os.urandom(2 * PIECE_BYTES)
    made, new = files.add(job_id, "Probe 3, Schürf 2.jpg", io.BytesIO(content))
    assert new
    assert (made.name, made.media_type, made.size) == ("Probe 3, Schürf 2.jpg", "image/jpeg", len(content))
    assert made.sha256 == hashlib.sha256(content).hexdigest()
    assert made.created_at.tzinfo is not None
    assert b"".join(files.content(job_id, made.sha256)) == content
    assert rows(service.store) == (1, 3)
    assert files.list(job_id) == [made]
    assert files.add(job_id, "again.jpg", io.BytesIO(content)) == (made, False)
    other = service.submit(line())[0].id
    assert files.list(other) == []
    assert files.add(other, "again.jpg", io.BytesIO(content))[1]


@ON_SQLITE
@pytest.mark.parametrize(
    ("name", "content", "media_type"),
    [
        ("a.png", PNG, "image/png"),
        ("a.JPEG", JPEG, "image/jpeg"),
        ("a.webp", b"RIFF\x10\x00\x00\x00WEBPVP8 ", "image/webp"),
        ("a.pdf", PDF, "application/pdf"),
        ("a.xlsx", workbook("[Content_Types].xml", "xl/workbook.xml"), "application/vnd.openxmlformats"),
        ("a.ods", open_document(), "application/vnd.oasis.opendocument.spreadsheet"),
        ("a.csv", "Zeit;Setzung\n1;0,5 µm\n".encode("latin-1"), "text/csv"),
        ("a.tsv", b"\xef\xbb\xbft\ts\r\n", "text/tab-separated-values"),
        ("a.ags", b'"GROUP","PROJ"\r\n', "text/plain"),
        ("notes.md", b"a < b", "text/plain"),
        ("Bildschirmfoto 10.00.00\u202fAM.png", PNG, "image/png"),
    ],
)
def test_the_content_says_what_a_file_is(service: JobService, name: str, content: bytes, media_type: str) -> None:
    job_id = service.submit(line())[0].id
    made, _ = service.attachments.add(job_id, name, io.BytesIO(content))
    assert made.media_type.startswith(media_type)
    assert made.name == name.replace("\u202f", " ")


@ON_SQLITE
@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("", PNG, "name: '' is no name"),
        ("..", PNG, "name: '..' is no name"),
        ("../../etc/a.png", PNG, "name: '../../etc/a.png' names a folder"),
        ("C:\\a.png", PNG, "names a folder"),
        ("a\n.png", PNG, r"name: 'a\n.png' has control characters"),
        ("a\x00.png", PNG, "has control characters"),
        ("gpj.\u202egnp.png", PNG, "has control characters"),
        ("ä" * 150 + ".png", PNG, "has 304 bytes; a name may have 200"),
        ("a.html", PNG, "name: 'a.html' must end with .png: its content is image/png"),
        ("a.png", JPEG, "must end with .jpg or .jpeg"),
        ("a.svg", b"<svg xmlns='http://www.w3.org/2000/svg'/>", "is of no type that can be attached; accepted: images"),
        ("a.txt", b" \n<html><script>alert(1)</script>", "content: 'a.txt' is HTML, SVG or XML"),
        ("a.csv", b"\xef\xbb\xbf<svg/>", "is HTML, SVG or XML"),
        ("a.csv", b"MZ\x90\x00\x03", "content: 'a.csv' is no text: it has the byte 0x00"),
        ("a.csv", b"1;2\n" * 100_000 + b"\x01", "it has the byte 0x01"),
        ("a.exe", b"MZ\x90\x00\x03", "is of no type that can be attached"),
        ("a.pdf", b"MZ\x90\x00\x03", "content: 'a.pdf' is not application/pdf by its content"),
        ("a.docx", workbook("word/document.xml"), "is of no type"),
        ("a.xlsx", workbook("xl/workbook.xml", "xl/vbaProject.bin"), "or has macros; save it as a workbook without"),
        ("a.png", b"", r"content: 'a.png' is empty \(0 bytes\)"),
    ],
)
def test_what_is_refused_is_named_with_what_is_accepted(
    service: JobService, name: str, content: bytes, words: str
) -> None:
    job_id = service.submit(line())[0].id
    with pytest.raises(AttachmentRefusedError, match=words.replace("\\n", r"\\n")) as refused:
        service.attachments.add(job_id, name, io.BytesIO(content))
    assert refused.value.field in ("name", "content")
    assert rows(service.store) == (0, 0)


def test_a_file_a_job_and_an_owner_have_limits(service: JobService) -> None:
    limits = {"attachment_mb": 1, "attachments_per_job": 3, "attachments_per_job_mb": 1.5, "quota_attachments_mb": 2}
    alice = limited(service, ALICE, **limits)
    first, second = (alice.submit(line())[0].id for _ in range(2))
    with pytest.raises(AttachmentRefusedError, match=r"has 1\.2 MB; at most 1 MB are accepted"):
        alice.attachments.add(first, "a.jpg", photo(1_200_000))
    alice.attachments.add(first, "a.jpg", photo(MB, b"a"))
    with pytest.raises(QuotaExceededError, match=r"has 1\.0 MB of files and this one 0\.6 MB more; at most 1\.5"):
        alice.attachments.add(first, "b.jpg", photo(600_000, b"b"))
    for seed in (b"c", b"d"):
        alice.attachments.add(first, "c.jpg", photo(1000, seed))
    with pytest.raises(QuotaExceededError, match="the job has 3 files; at most 3 can be attached"):
        alice.attachments.add(first, "e.jpg", photo(1000, b"e"))
    assert not alice.attachments.add(first, "a.jpg", photo(MB, b"a"))[1]  # nothing new, nothing refused
    with pytest.raises(QuotaExceededError, match=r"the jobs of alice have 1\.0 MB of files and this one 1\.0 MB more"):
        alice.attachments.add(second, "f.jpg", photo(MB, b"f"))
    limited(service, ADMIN, **limits).attachments.add(second, "f.jpg", photo(MB, b"f"))
    bob = limited(service, BOB, **limits)
    bob.attachments.add(bob.submit(line())[0].id, "a.jpg", photo(MB, b"a"))


def test_files_count_in_the_data_of_an_owner_and_of_the_database(service: JobService) -> None:
    alice = limited(service, ALICE, quota_mb=1.0)
    job_id = alice.submit(line())[0].id
    with pytest.raises(QuotaExceededError, match=r"and this file 1\.0 MB more; .* \(GEOSWARM_QUOTA_MB\)"):
        alice.attachments.add(job_id, "a.jpg", photo(MB))
    made, _ = alice.attachments.add(job_id, "a.jpg", photo(850_000))
    with pytest.raises(QuotaExceededError, match="GEOSWARM_QUOTA_MB"):
        alice.submit(line(stopping={"max_evaluations": 300}))
    alice.attachments.delete(job_id, made.sha256)
    assert alice.submit(line(stopping={"max_evaluations": 300}))[1]
    total = service.store.size_bytes() / MB + 0.5
    with pytest.raises(QuotaExceededError, match=r"this file 0\.9 MB more; .*GEOSWARM_QUOTA_TOTAL_MB"):
        limited(service, ALICE, quota_total_mb=total).attachments.add(job_id, "a.jpg", photo(900_000))


@pytest.mark.parametrize("limit", [{"attachments_per_job": 1}, {"attachments_per_job_mb": 1.0}, {"quota_mb": 1.0}])
def test_two_uploads_at_once_do_not_both_take_the_last_room(
    service: JobService, monkeypatch: pytest.MonkeyPatch, limit: dict[str, float]
) -> None:
    alice = limited(service, ALICE, **limit)
    job_id = alice.submit(line())[0].id
    together(monkeypatch)
    found = at_once(*(partial(alice.attachments.add, job_id, "a.jpg", photo(700_000, seed)) for seed in (b"a", b"b")))
    assert sorted(type(one) for one in found if not isinstance(one, tuple)) == [QuotaExceededError]
    assert len(alice.attachments.list(job_id)) == 1


def test_the_same_file_twice_at_once_is_attached_once(service: JobService, monkeypatch: pytest.MonkeyPatch) -> None:
    job_id = service.submit(line())[0].id
    together(monkeypatch)
    found = at_once(*(partial(service.attachments.add, job_id, "a.jpg", photo(700_000)) for _ in range(2)))
    made = [one for one in found if isinstance(one, tuple)]
    assert sorted(new for _, new in made) == [False, True]
    assert made[0][0] == made[1][0]


def together(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let two uploads meet behind their look for the same file, if they can."""
    look, meeting = module.find_attachment, threading.Barrier(2)

    def meets(*given: object) -> object:
        found = look(*given)  # type: ignore[arg-type]
        try:
            meeting.wait(1.0)
        except threading.BrokenBarrierError:
            return found
        return found

    monkeypatch.setattr(module, "find_attachment", meets)


def at_once(*uploads: Callable[[], tuple[Attachment, bool]]) -> list[tuple[Attachment, bool] | QuotaExceededError]:
    def result(one: Callable[[], tuple[Attachment, bool]]) -> tuple[Attachment, bool] | QuotaExceededError:
        try:
            return one()
        except QuotaExceededError as error:
            return error

    with ThreadPoolExecutor(len(uploads)) as threads:
        return list(threads.map(result, uploads))


def test_files_go_with_their_job(service: JobService) -> None:
    job_id, other = (service.submit(line())[0].id for _ in range(2))
    for seed in (b"a", b"b", b"c"):
        service.attachments.add(job_id, "a.jpg", photo(2 * PIECE_BYTES, seed))
    service.attachments.add(other, "a.jpg", photo())
    service.cancel(job_id)
    delete_job(service.store, job_id)
    assert rows(service.store) == (1, 1)
    with pytest.raises(JobNotFoundError):
        service.attachments.list(job_id)


def test_a_job_is_deleted_before_or_after_an_upload(service: JobService, monkeypatch: pytest.MonkeyPatch) -> None:
    """Not in its middle, when its job has been looked for."""
    job_id = service.submit(line())[0].id
    service.cancel(job_id)
    check = module.check_attachment_quotas
    with ThreadPoolExecutor(1) as threads:

        def deleted_now(*given: object, **named: object) -> None:
            deleting.append(threads.submit(delete_job, service.store, job_id))
            with contextlib.suppress(TimeoutError):
                deleting[0].result(0.5)
            check(*given, **named)  # type: ignore[arg-type]

        deleting: list[Future[None]] = []
        monkeypatch.setattr(module, "check_attachment_quotas", deleted_now)
        assert service.attachments.add(job_id, "a.jpg", photo())[1]
        deleting[0].result(PATIENCE)
    assert rows(service.store) == (0, 0)
    with pytest.raises(JobNotFoundError):
        service.attachments.add(job_id, "a.jpg", photo())


@ON_SQLITE
def test_nothing_of_a_deleted_file_is_left_in_the_database(service: JobService, tmp_path: Path) -> None:
    mark = b"confidential-photo-of-the-harbour"
    job_id = service.submit(line())[0].id
    made, _ = service.attachments.add(job_id, "a.jpg", photo(600_000, mark))
    assert any(mark in file.read_bytes() for file in tmp_path.glob("jobs.db*"))
    service.attachments.delete(job_id, made.sha256)
    assert not any(mark in file.read_bytes() for file in tmp_path.glob("jobs.db*"))
    with sqlite3.connect(tmp_path / "jobs.db") as file:
        assert file.execute("SELECT count(*) FROM attachment_pieces").fetchone() == (0,)
    file.close()
    with pytest.raises(AttachmentNotFoundError, match="has no file with the SHA-256"):
        service.attachments.delete(job_id, made.sha256)


def test_the_files_of_somebody_else_are_not_there(service: JobService) -> None:
    """Whatever the method, also one that is added later."""
    alice = service.on_behalf_of(ALICE)
    job_id = alice.submit(line())[0].id
    made, _ = alice.attachments.add(job_id, "a.jpg", photo())
    given = {"list": (), "add": ("b.jpg", photo(seed=b"b"))}
    tried = [name for name in dir(Attachments) if not name.startswith("_")]
    for name in tried:
        for stranger in (BOB, Principal(None, "read"), Principal("alice", "agent")):
            with pytest.raises(JobNotFoundError):
                getattr(service.on_behalf_of(stranger).attachments, name)(job_id, *given.get(name, (made.sha256,)))
    assert len(tried) == 5
    assert service.on_behalf_of(Principal("alice", "read")).attachments.list(job_id) == [made]
    assert service.on_behalf_of(ADMIN).attachments.list(job_id) == [made]


@ON_SQLITE
def test_a_disk_that_is_full_takes_no_file(service: JobService) -> None:
    job_id = service.submit(line())[0].id
    full = limited(service, ADMIN, disk_reserve_mb=1e9)
    with pytest.raises(StoreUnavailableError, match="GEOSWARM_DISK_RESERVE_MB"):
        full.attachments.add(job_id, "a.jpg", photo())
    made, _ = service.attachments.add(job_id, "a.jpg", photo())
    full.attachments.delete(job_id, made.sha256)
    assert service.attachments.list(job_id) == []


def test_no_file_is_held_in_memory(service: JobService, tmp_path: Path) -> None:
    """20 MB, attached and read: as much of it at once as some pieces have."""
    job_id = service.submit(line())[0].id
    service.attachments.add(job_id, "a.jpg", photo())
    with (tmp_path / "large.jpg").open("w+b") as file:
        file.write(JPEG + os.urandom(20 * MB - 4))
        tracemalloc.start()
        made, _ = service.attachments.add(job_id, "large.jpg", file)
        read = sum(map(len, service.attachments.content(job_id, made.sha256)))
        most = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
    assert read == 20 * MB
    assert most < 8 * PIECE_BYTES
