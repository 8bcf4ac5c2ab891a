from __future__ import annotations

import re
from pathlib import Path

import pytest
from sqlalchemy import select, update

from geoswarm.workers.access.keys import KEY_PATTERN, ApiKeys
from geoswarm.workers.access.principal import LOCAL, Principal
from geoswarm.workers.errors import KeyNotFoundError, SettingsError, StoreUnavailableError
from geoswarm.workers.settings import Settings
from geoswarm.workers.store import Store
from geoswarm.workers.store.clock import database_now
from geoswarm.workers.store.tables import api_keys
from tests.workers.conftest import ON_SQLITE


@pytest.fixture
def ring(store: Store) -> ApiKeys:
    return ApiKeys(store)


def test_a_key_opens_for_its_owner_and_only_its_hash_is_kept(ring: ApiKeys, store: Store) -> None:
    assert not ring.used()
    key, view = ring.create("alice", "submit", label="laptop")
    assert KEY_PATTERN.fullmatch(key)
    assert ring.principal(key) == Principal("alice", "submit", view.id)
    assert (view.state, view.label, view.expires_at) == ("active", "laptop", None)
    row = store.read(lambda connection: connection.execute(select(api_keys)).one())
    assert key.split("_", 2)[2] not in " ".join(map(str, row))  # the secret itself may contain "_"
    assert re.fullmatch("[0-9a-f]{64}", row.hash)
    assert ring.used()


@ON_SQLITE
def test_two_keys_are_never_alike(ring: ApiKeys) -> None:
    keys = {ring.create("alice", "read")[0] for _ in range(20)}
    assert len(keys) == 20
    assert [view.owner for view in ring.list()] == ["alice"] * 20


@ON_SQLITE
def test_wrong_keys_open_nothing(ring: ApiKeys) -> None:
    key, view = ring.create("alice", "admin")
    other, _ = ring.create("bob", "read")
    mixed = f"gsw_{view.id}_{other[17:]}"
    for wrong in ("", "x", key[:-1], key + "x", key.replace("gsw", "GSW"), mixed, f"gsw_{'0' * 12}_{'A' * 43}"):
        assert ring.principal(wrong) is None


def test_a_revoked_key_opens_nothing_more_and_the_door_stays_shut(ring: ApiKeys) -> None:
    key, view = ring.create("alice", "submit")
    revoked = ring.revoke(view.id)
    assert revoked.state == "revoked"
    assert ring.revoke(view.id).revoked_at == revoked.revoked_at
    assert ring.principal(key) is None
    assert ring.used()
    with pytest.raises(KeyNotFoundError, match="keys list"):
        ring.revoke("nothing")


def test_an_expired_key_opens_nothing(ring: ApiKeys, store: Store) -> None:
    key, view = ring.create("alice", "submit", valid_seconds=3600)
    assert view.expires_at is not None
    assert (view.expires_at - view.created_at).total_seconds() == pytest.approx(3600, abs=60)
    assert ring.principal(key) is not None
    store.write(lambda connection: connection.execute(update(api_keys).values(expires_at=database_now() - 1)))
    assert ring.principal(key) is None
    assert ring.list()[0].state == "expired"


def test_the_last_use_is_noted_but_not_every_time(ring: ApiKeys) -> None:
    key, _ = ring.create("alice", "submit")
    assert ring.list()[0].used_at is None
    ring.principal(key)
    first = ring.list()[0].used_at
    assert first is not None
    ring.principal(key)
    assert ring.list()[0].used_at == first


def test_a_key_opens_for_reading_while_nothing_can_be_written(
    ring: ApiKeys, store: Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    key, _ = ring.create("alice", "read")

    def full(_function: object) -> None:
        raise StoreUnavailableError("database or disk is full")

    monkeypatch.setattr(store, "write", full)
    assert ring.principal(key) is not None


@ON_SQLITE
@pytest.mark.parametrize(
    ("owner", "role", "label", "seconds", "said"),
    [
        ("", "read", "", None, "letters, digits"),
        ("a\nb", "read", "", None, "letters, digits"),
        ("-x", "read", "", None, "letters, digits"),
        ("a" * 81, "read", "", None, "at most 80"),
        ("alice", "root", "", None, "read, submit, admin"),
        ("alice", "read", "\x1b[31m", None, "printable"),
        ("alice", "read", "", 0.0, "must be above 0 s, got 0 s"),
    ],
)
def test_what_a_key_cannot_be(
    ring: ApiKeys, owner: str, role: str, label: str, seconds: float | None, said: str
) -> None:
    with pytest.raises(SettingsError, match=said):
        ring.create(owner, role, label=label, valid_seconds=seconds)  # type: ignore[arg-type]
    assert ring.list() == []


def test_roles_include_one_another() -> None:
    reader, submitter = Principal("a", "read"), Principal("a", "submit")
    assert (reader.may("read"), reader.may("submit"), submitter.may("read"), submitter.may("admin")) == (
        True,
        False,
        True,
        False,
    )
    assert LOCAL.may("admin")
    assert LOCAL.sees(None)
    assert LOCAL.sees("anybody")
    assert not Principal(None, "read").sees(None)
    assert (reader.sees("a"), reader.sees("b"), reader.sees(None)) == (True, False, False)


def test_a_keyring_does_not_put_keys_into_the_file(tmp_path: Path) -> None:
    store = Store(Settings(database_url=f"sqlite:///{tmp_path}/jobs.db"))
    key, _ = ApiKeys(store).create("alice", "submit")
    ApiKeys(store).principal(key)
    store.close()
    secret = key[17:].encode()
    assert all(secret not in path.read_bytes() for path in tmp_path.iterdir())
