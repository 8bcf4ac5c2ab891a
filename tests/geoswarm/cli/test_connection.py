"""Which job the commands mean by ``latest``, and which proposal by a key."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import pytest

from geoswarm.cli.local.statistics import _follow_up, proposals_by_key
from geoswarm.cli.service.connection import find_calibration, find_job
from geoswarm.cli.words.error_messages import BadInputError
from geoswarm.client import Client, NotFoundError
from tests.solver.problems import decay_document


class Jobs:
    """A service with a calibration, its sensitivities and profiles of these."""

    def __init__(self, **of: str | None) -> None:
        self.of = of

    def list(self, limit: int) -> Any:
        return SimpleNamespace(items=[SimpleNamespace(id=list(self.of)[-1])][:limit])

    def get(self, job: str) -> Any:
        if job not in self.of:
            raise NotFoundError(404, "not-found", "no such job")
        return SimpleNamespace(id=job)

    def problem(self, job: str) -> dict[str, Any]:
        return {"method": {"kind": "sensitivity"} | ({} if self.of[job] is None else {"of": self.of[job]})}


def client(**of: str | None) -> Client:
    return cast(Client, Jobs(**of))


def test_latest_is_the_calibration_that_a_follow_up_examines(capsys: pytest.CaptureFixture[str]) -> None:
    jobs = client(run=None, sensitivity="run")
    assert find_calibration(jobs, "latest").id == "run"
    assert "The newest job, sensitivity, is a follow-up: this is the calibration run" in capsys.readouterr().err
    assert find_job(jobs, "latest").id == "sensitivity"
    assert find_calibration(jobs, "sensitivity").id == "sensitivity"  # who names it means it
    assert find_calibration(client(run=None), "latest").id == "run"
    assert find_calibration(client(run=None, first="run", second="first"), "latest").id == "run"
    assert find_calibration(client(orphan="deleted"), "latest").id == "orphan"


def proposal(kind: str, name: str, partner: str | None, **section: Any) -> dict[str, Any]:
    changes = {"parameters": {name: section}} if section else {}
    line = None if partner is None else {"partner": partner}
    return {"kind": kind, "parameter": name, "sentence": f"{kind} {name}", "changes": changes, "line": line}


def test_every_proposal_has_a_key_of_its_own(capsys: pytest.CaptureFixture[str]) -> None:
    found = {
        "verdicts": [
            {
                "proposals": [
                    proposal("link", "rate", "amplitude", expression="0.5 * amplitude"),
                    proposal("link", "rate", "k", expression="0.1 * k"),
                    proposal("fix", "rate", None, value=0.7),
                    proposal("add_test", "rate", None),
                ]
            },
            {"proposals": [proposal("link", "k", "rate", expression="2 * rate")]},
        ]
    }
    assert list(proposals_by_key(found)) == ["link:rate:amplitude", "link:rate:k", "fix:rate", "link:k"]
    document = decay_document()
    with pytest.raises(BadInputError, match="give link:rate:amplitude or link:rate:k"):
        _follow_up(found, document, ("link:rate",), None)
    with pytest.raises(BadInputError, match="there are: link:rate:amplitude, link:rate:k, fix:rate, link:k"):
        _follow_up(found, document, ("add_test:rate",), None)
    _follow_up(found, document, ("link:rate:amplitude",), None)
    assert '"expression": "0.5 * amplitude"' in capsys.readouterr().out
