"""No test outside those marked ``timing`` fails because the machine is slow: no limit on its time is below 30 s."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator

import pytest

from tests.contracts.repository import ROOT

LEAST = 30.0
CLOCK = re.compile(r"monotonic|perf_counter|process_time|time\.time|elapsed|took|duration|seconds|longest|\.stop\(")
PROCESS = re.compile("process|client|child|theirs|holder")
WAITS = {"wait_for": 2, "wait": 0, "communicate": None}  # the place of the limit, if it needs no name


def is_short(node: ast.expr | None) -> bool:
    return isinstance(node, ast.Constant) and isinstance(node.value, int | float) and node.value < LEAST


def short_limits(test: ast.AST) -> Iterator[int]:
    """Lines in which a test fails after less than 30 s."""
    for node in parts(test):
        if isinstance(node, ast.Assert):
            yield from (node.lineno for part in ast.walk(node.test) if isinstance(part, ast.Compare) and bounded(part))
        if isinstance(node, ast.Expr | ast.Assert | ast.Assign):
            inner = node.test if isinstance(node, ast.Assert) else node.value
            paused = isinstance(node, ast.Expr)  # an event that has not come by then is no error
            yield from (node.lineno for part in parts(inner) if isinstance(part, ast.Call) and waits(part, paused))


def parts(node: ast.AST) -> Iterator[ast.AST]:
    """A node and what is below it, but for what must not happen meanwhile (``not event.wait(0.3)``, an error)."""
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
        return
    if isinstance(node, ast.With) and "pytest.raises" in ast.unparse(node.items[0]):
        return
    yield node
    for child in ast.iter_child_nodes(node):
        yield from parts(child)


def bounded(compared: ast.Compare) -> bool:
    """Whether a time must be less than a constant."""
    values = [compared.left, *compared.comparators]
    for left, operator, right in zip(values, compared.ops, values[1:], strict=False):
        if isinstance(operator, ast.Gt | ast.GtE):
            left, right = right, left
        elif not isinstance(operator, ast.Lt | ast.LtE):
            continue
        if is_short(right) and CLOCK.search(ast.unparse(left)):
            return True
    return False


def waits(call: ast.Call, paused: bool) -> bool:
    """Whether something fails if it has not happened after a constant time; a pause waits for processes only."""
    name = call.func.attr if isinstance(call.func, ast.Attribute) else getattr(call.func, "id", "")
    if name not in WAITS or (paused and name == "wait" and not PROCESS.search(ast.unparse(call.func))):
        return False
    place = WAITS[name]
    given = [word.value for word in call.keywords if word.arg in ("timeout", "seconds")]
    given += call.args[place : place + 1] if place is not None else []
    return any(is_short(limit) for limit in given)


def is_timing(node: ast.AST) -> bool:
    return isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef) and any(
        "timing" in ast.unparse(decorator) for decorator in node.decorator_list
    )


def test_no_test_fails_because_the_machine_is_slow() -> None:
    found = []
    for file in sorted((ROOT / "tests").rglob("*.py")):
        module = ast.parse(file.read_text(encoding="utf-8"))
        for node in module.body:
            if not is_timing(node):
                found += [f"{file.relative_to(ROOT)}:{line}" for line in short_limits(node)]
    assert found == [], "mark the test with pytest.mark.timing, or wait for a fact with a limit of 30 s or more"


@pytest.mark.parametrize(
    ("line", "found"),
    [
        ("assert time.monotonic() - began < 15.0", True),
        ("assert 0.6 <= row.run_seconds < 1.01", True),
        ("assert 2.0 > server.stop()", True),
        ("wait_for(lambda: True, 'the end', 5.0)", True),
        ("process.wait(20)", True),
        ("output, errors = process.communicate(timeout=10)", True),
        ("assert started.wait(10)", True),
        ("assert time.monotonic() - began < 60.0", False),
        ("assert 0.4 <= row.run_seconds", False),
        ("assert not entered.wait(0.3)", False),
        ("process.wait(60)", False),
        ("stopping.wait(0.02)", False),
        ("with pytest.raises(Late):\n    client.wait(job, timeout=0.5)", False),
    ],
)
def test_short_limits_are_seen(line: str, found: bool) -> None:
    assert any(short_limits(ast.parse(line))) is found
