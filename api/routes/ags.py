"""Files in the AGS 4 format: what they hold, and the problem that some of it makes."""

from __future__ import annotations

from dataclasses import asdict
from typing import Annotated, Any, Literal

import anyio.to_thread
from fastapi import APIRouter, Query, Request

from geoswarm.api.access.bodies import FileContent
from geoswarm.api.dependencies import limiter, problems_of
from geoswarm.api.errors import DetailError
from geoswarm.api.schemas.ags import AgsContents, AgsProblem
from geoswarm.solver.errors import Issue

__all__ = ["router"]

router = APIRouter(prefix="/measurements/ags", tags=["problems"])

MAX_LISTED = 2000
MAX_CHOSEN = 200
BODY = {
    "required": True,
    "description": "the file as it is",
    "content": {"application/octet-stream": {"schema": {"type": "string", "format": "binary"}}},
}
FileName = Annotated[str, Query(max_length=200, description="name of the file, for messages and notes")]
SpecimenId = Annotated[str, Query(min_length=1, max_length=500)]


@router.post("", responses=problems_of(408, 413, 422), openapi_extra={"requestBody": BODY})
async def list_tests(content: FileContent, request: Request, name: FileName = "file.ags") -> AgsContents:
    """List the tests and readings of a file in the AGS 4 format, and what can be made of them. Nothing is stored."""
    slot = limiter(request, "files")
    return await anyio.to_thread.run_sync(_listed, content, name, limiter=slot)


@router.post("/problem", responses=problems_of(408, 413, 422), openapi_extra={"requestBody": BODY})
async def import_tests(
    content: FileContent,
    request: Request,
    name: FileName = "file.ags",
    specimen: Annotated[
        list[SpecimenId] | None,
        Query(
            max_length=MAX_CHOSEN,
            description="ID as listed, or what IDs begin with (BH1: all of that borehole); several make a combined "
            "problem; may be left out where the file holds one test",
        ),
    ] = None,
    material: Annotated[
        str | None,
        Query(max_length=100, description="soil law; soft_soil, or mohr_coulomb for drained shear tests alone"),
    ] = None,
    stage_duration: Annotated[
        float, Query(gt=0.0, le=1e6, description="of each increment of an oedometer test, day")
    ] = 1.0,
    initial_stress: Annotated[
        float | None,
        Query(
            gt=0.0,
            le=1e9,
            description="vertical stress before the first increment of an oedometer test, kPa; a tenth of that of the "
            "increment if absent",
        ),
    ] = None,
    words: Annotated[
        Literal["keys", "fields"],
        Query(description="how notes and messages name what can be given: by keys, or by fields of the dashboard"),
    ] = "keys",
) -> AgsProblem:
    """Convert tests of a file into a problem, and monitoring into CSV files, as ``geoswarm import ags``. Nothing is
    stored."""
    wishes = {"duration": stage_duration, "material": material, "initial_stress": initial_stress}
    slot = limiter(request, "files")
    return await anyio.to_thread.run_sync(_imported, content, name, specimen or [], wishes, words, limiter=slot)


def _listed(content: bytes, name: str) -> AgsContents:
    from geoswarm.solver.ags.contents import contents_of, entries  # with soil laws, for which a start should not wait
    from geoswarm.solver.ags.reading import read_ags
    from geoswarm.solver.ags.tables import AgsError

    try:
        found = [asdict(entry) for entry in entries(contents_of(read_ags(content, name)))]
    except AgsError as error:
        raise _unreadable(error) from None
    return AgsContents.model_validate({"name": name, "count": len(found), "items": found[:MAX_LISTED]})


def _imported(content: bytes, name: str, specimens: list[str], wishes: dict[str, Any], words: str) -> AgsProblem:
    from geoswarm.solver.ags.contents import contents_of, picked
    from geoswarm.solver.ags.document import made_of, with_points
    from geoswarm.solver.ags.reading import read_ags
    from geoswarm.solver.ags.tables import AgsError
    from geoswarm.solver.ags.wishes import FORM, KEYS, Wishes

    asked = FORM if words == "fields" else KEYS
    try:
        contents = picked(contents_of(read_ags(content, name)), specimens, asked.specimen)
        made = made_of(contents, Wishes(**wishes, asked=asked))
    except AgsError as error:
        raise _unreadable(error) from None
    return AgsProblem.model_validate(
        {
            "name": name,
            "specimens": list(dict.fromkeys(part.id for part in made.parts)),
            "problem": with_points(made, name),
            "notes": list(made.notes),
            "readings": [{"name": f"{one}.csv", "csv": csv.decode()} for one, csv in made.instruments.items()],
        }
    )


def _unreadable(error: Exception) -> DetailError:
    issues = [Issue("", str(error))]
    return DetailError(422, str(error), kind="unreadable-file", title="File cannot be read", issues=issues)
