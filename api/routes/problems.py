"""Problems before they become jobs, and the examples that come with the program."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

import anyio.to_thread
from fastapi import APIRouter, Request
from fastapi.responses import JSONResponse
from pydantic import ValidationError

from geoswarm.api.access.bodies import ProblemDocument, ProblemText
from geoswarm.api.dependencies import Service, limiter, problems_of
from geoswarm.api.drafts import describe_draft, find_examples
from geoswarm.api.errors import DetailError
from geoswarm.api.routes.jobs import PROBLEM_BODY
from geoswarm.api.schemas.drafts import Example, ExampleList, ExampleSummary, FilesOfTests, ProblemDraft, ProblemOfTests
from geoswarm.api.schemas.responses import WarmStarts
from geoswarm.api.views import read_record
from geoswarm.records.problem import CheckResult
from geoswarm.solver.errors import ProblemError
from geoswarm.solver.problem import draft_of_document, draft_of_text, parse_problem, problem_schema, read_document
from geoswarm.solver.problem.draft import document_of_tests
from geoswarm.solver.problem.issues import issues_of
from geoswarm.solver.problem.text.reading import Form
from geoswarm.solver.registered.schema import registered_models, section_schema

__all__ = ["examples_router", "router"]

router = APIRouter(prefix="/problems", tags=["problems"])

TESTS_BODY = {
    "required": True,
    "description": "a problem with `tests`, and the files that these name",
    "content": {
        "application/json": {"schema": FilesOfTests.model_json_schema()},
        "application/yaml": {"schema": {"type": "string"}},
    },
}


@router.post("/check", responses=problems_of(400, 408, 413, 415, 422), openapi_extra={"requestBody": PROBLEM_BODY})
async def check(document: ProblemDocument, request: Request, service: Service) -> CheckResult:
    """Validate a problem, make one test run and estimate the cost. Nothing is stored."""
    problem = await anyio.to_thread.run_sync(parse_problem, document)
    report = await anyio.to_thread.run_sync(service.check, problem, limiter=limiter(request, "test runs"))
    earlier = await anyio.to_thread.run_sync(service.warm_starts, problem)
    return read_record(CheckResult, asdict(report) | {"warm_starts": [asdict(job) for job in earlier]})


@router.post(
    "/warm-starts", responses=problems_of(400, 408, 413, 415, 422), openapi_extra={"requestBody": PROBLEM_BODY}
)
async def warm_starts(document: ProblemDocument, service: Service) -> WarmStarts:
    """List earlier jobs with the same forward model whose stored evaluations the search can use."""
    problem = await anyio.to_thread.run_sync(parse_problem, document)
    return WarmStarts(items=await anyio.to_thread.run_sync(service.warm_starts, problem))


@router.post("/read", responses=problems_of(400, 408, 413, 415), openapi_extra={"requestBody": PROBLEM_BODY})
async def read(given: ProblemText, request: Request) -> ProblemDraft:
    """Read a draft of a problem: as a document and as YAML, with all its mistakes by line. Nothing runs.

    YAML that cannot be read also gets an answer, with the mistake in ``issues``.
    """
    text, form = given
    return await anyio.to_thread.run_sync(_draft, text, form, limiter=limiter(request, "drafts"))


@router.post("/tests", responses=problems_of(400, 408, 413, 415, 422), openapi_extra={"requestBody": TESTS_BODY})
async def make_tests(document: ProblemDocument, request: Request) -> ProblemOfTests:
    """Make parts and observations of a table of laboratory tests and its files. Nothing is stored.

    What the problem lacks beyond its tests is no mistake here.
    """
    return await anyio.to_thread.run_sync(_of_tests, document, limiter=limiter(request, "drafts"))


@router.get("/schema", response_model=dict[str, Any], responses=problems_of())
def schema() -> JSONResponse:
    """Show the JSON schema of the problem file, with the sections of all installed forward models."""
    found = problem_schema()
    for name, declaration in registered_models():  # for forms; any of them is a forward_model_registered
        found["$defs"][f"forward_model_registered_{name}"] = section_schema(name, declaration)
    return JSONResponse(found)  # as it is: 0.2 MB, which FastAPI would look through once more


def _of_tests(document: dict[str, Any]) -> ProblemOfTests:
    try:
        given = FilesOfTests.model_validate(document)
    except ValidationError as error:
        raise ProblemError(issues_of(error, document, "", FilesOfTests.model_json_schema)) from None
    return ProblemOfTests(problem=document_of_tests(given.problem, given.files))


def _draft(text: str, form: Form) -> ProblemDraft:
    try:
        return describe_draft(draft_of_text(text) if form == "yaml" else draft_of_document(read_document(text, form)))
    except ProblemError as error:
        raise DetailError(400, str(error), kind="malformed-body", title="Malformed body", issues=error.issues) from None


examples_router = APIRouter(prefix="/examples", tags=["problems"])


@examples_router.get("", responses=problems_of())
def list_examples() -> ExampleList:
    """List the examples."""
    return ExampleList(items=[ExampleSummary.model_validate(one.model_dump()) for one in find_examples().values()])


@examples_router.get("/{name}", responses=problems_of(404))
def show_example(name: str) -> Example:
    """Show an example with its problem, which can be submitted as it is."""
    found = find_examples().get(name)
    if found is None:
        known = ", ".join(find_examples())
        raise DetailError(404, f"There is no example '{name[:80]}'; known: {known}.", kind="unknown-example")
    return found
