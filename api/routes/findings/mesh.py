"""Meshes and fields of jobs whose forward model has a body."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any

import anyio.to_thread
from fastapi import APIRouter, Depends, Query, Request

from geoswarm.api.dependencies import JobId, Service, limiter, problems_of, require_runs
from geoswarm.api.errors import DetailError
from geoswarm.api.schemas.mesh import MeshAnswer, MeshFields
from geoswarm.solver.report.curves import objective_unit
from geoswarm.solver.report.jsonable import jsonable
from geoswarm.workers.errors import NoBodyError
from geoswarm.workers.service.job_service import JobService

if TYPE_CHECKING:
    from geoswarm.workers.service.bodies import EvaluatedBody

__all__ = ["router"]

router = APIRouter(prefix="/jobs/{job_id}/mesh", tags=["mesh"])

LARGEST = 2**31 - 1


@dataclass(frozen=True, slots=True)
class Wanted:
    """Which body: part and evaluation."""

    part: str | None
    generation: int | None
    particle: int | None


def _wanted(
    part: Annotated[
        str | None, Query(max_length=100, description="of a combined model; the first with a mesh if absent")
    ] = None,
    generation: Annotated[
        int | None, Query(ge=0, le=LARGEST, description="of the evaluation; the best one if absent")
    ] = None,
    particle: Annotated[int | None, Query(ge=0, le=LARGEST)] = None,
) -> Wanted:
    return Wanted(part, generation, particle)


WantedBody = Annotated[Wanted, Depends(_wanted)]
PhaseName = Annotated[str | None, Query(max_length=200)]


@router.get("", responses=problems_of(404, 422))
def mesh(job_id: JobId, service: Service, wanted: WantedBody) -> MeshAnswer:
    """Show the mesh of an evaluation, and the displacements of its points, measured and calculated; runs nothing."""
    body = _body(service, job_id, wanted)
    start, end = body.period
    ends = body.model.phase_ends
    content: dict[str, Any] = {
        "part": body.part,
        "parts": body.parts,
        "generation": body.generation,
        "particle": body.particle,
        "objective": body.objective,
        "objective_unit": objective_unit(body.problem),
        "parameters": {} if body.free is None else body.problem.values(body.free.tolist()),
        "nodes": body.mesh.nodes,
        "triangles": body.mesh.triangles,
        "regions": body.mesh.regions,
        "region_names": body.mesh.region_names,
        "interfaces": body.mesh.interfaces,
        "points": body.mesh.points,
        "phases": [{"name": p.name, "kind": p.kind, "end": ends[p.name]} for p in body.model.body.phases],
        "start": start,
        "end": end,
        "vectors": [
            {
                "name": v.name,
                "point": v.point,
                "x": v.place[0],
                "y": v.place[1],
                "start": v.start,
                "end": v.end,
                "measured": v.measured,
                "calculated": v.calculated,
            }
            for v in body.vectors
        ],
    }
    return MeshAnswer.model_validate(jsonable(content))


@router.get("/fields", responses=problems_of(404, 409, 422))
async def fields(
    job_id: JobId,
    service: Service,
    request: Request,
    wanted: WantedBody,
    start: PhaseName = None,
    end: PhaseName = None,
    since_beginning: Annotated[bool, Query(description="start before the first phase, regardless of start")] = False,
) -> MeshFields:
    """Calculate displacements and shear strains between the ends of two phases, the usual period if absent.

    The first request for an evaluation runs its forward model once more, within the limits of a test run, and so needs
    the role ``submit``; the result is kept for later requests.
    """
    require_runs(service)

    def calculate() -> MeshFields:
        body = _body(service, job_id, wanted)
        usual_start, usual_end = body.period
        first = None if since_beginning else usual_start if start is None else start
        try:
            found = service.bodies.fields(job_id, body, first, usual_end if end is None else end)
        except NoBodyError as error:
            raise DetailError(409, f"{error}.", kind="no-fields", title="No fields") from None
        content = {
            "start": found.start,
            "end": found.end,
            "generation": body.generation,
            "particle": body.particle,
            "displacement": found.displacement,
            "shear_strain": found.shear_strain,
        }
        return MeshFields.model_validate(jsonable(content))

    return await anyio.to_thread.run_sync(calculate, limiter=limiter(request, "test runs"))


def _body(service: JobService, job_id: str, wanted: Wanted) -> EvaluatedBody:
    try:
        return service.bodies.body(job_id, part=wanted.part, generation=wanted.generation, particle=wanted.particle)
    except NoBodyError as error:
        raise DetailError(404, f"{error}.", kind="no-mesh", title="No mesh") from None
