"""Puts the HTTP service together."""

from __future__ import annotations

from importlib.metadata import PackageNotFoundError, version
from typing import TYPE_CHECKING, Any

from fastapi import APIRouter, FastAPI
from fastapi.openapi.utils import get_openapi
from fastapi.routing import APIRoute

from geoswarm.api.access.authentication import SESSION_COOKIE, Authenticator
from geoswarm.api.access.gate import SIGN_IN, Gate
from geoswarm.api.access.intake import Intake
from geoswarm.api.access.limits import Shares
from geoswarm.api.assets import Assets
from geoswarm.api.compute.middleware import ComputeMiddleware
from geoswarm.api.errors import ProblemDetail, install_error_handlers
from geoswarm.api.events.feed import EventFeed
from geoswarm.api.events.open_work import OpenWorkWatch
from geoswarm.api.observe import Observer, RequestMetrics
from geoswarm.api.pages import error_page
from geoswarm.api.pages import router as pages_router
from geoswarm.api.routes import api_router, health_router, metrics_router
from geoswarm.api.schemas.agents import Brought
from geoswarm.api.settings import API_PREFIX, ApiSettings
from geoswarm.solver.problem import problem_schema
from geoswarm.workers.agents.handed_out import HandedOut
from geoswarm.workers.service.job_service import JobService

if TYPE_CHECKING:
    from geoswarm.api.compute.pool import ComputePool

__all__ = ["create_app"]

KEYED = (API_PREFIX, "/metrics")
DESCRIPTION = """Finds the parameters of geotechnical models from measurements.

Submit a problem, follow its events, read the best parameters. Units inside: kN, m, day, degree; timestamps are UTC.
Errors are problem details (RFC 9457)."""


def _operation_id(route: APIRoute) -> str:
    return route.name


ROUTES = APIRouter(generate_unique_id_function=_operation_id)
"""All routes, put together once a process: an application that includes them itself builds all their models again."""
# Where no prefix is given, FastAPI looks at the paths, and builds the models of nested routers once more for that.
for _router, _prefix in ((health_router, ""), (metrics_router, ""), (api_router, API_PREFIX), (pages_router, "")):
    ROUTES.include_router(_router, prefix=_prefix)


def create_app(
    service: JobService,
    settings: ApiSettings | None = None,
    *,
    pool: ComputePool | None = None,
    door: bool = True,
) -> FastAPI:
    """Build the application on a service that the caller opens and closes.

    Parameters
    ----------
    service
        What the routes work on.
    settings
        API key and limits; the defaults answer only to loopback names.
    pool
        Processes for requests that calculate; None: they are worked on here.
    door
        Check the sender, the rate and the size; False inside such a process, where the service has done so.
    """
    settings = settings or ApiSettings()
    app = FastAPI(
        title="geoswarm",
        version=_version(),
        description=DESCRIPTION,
        openapi_url="/openapi.json",
        docs_url=None,  # these pages would load scripts from elsewhere
        redoc_url=None,
        redirect_slashes=False,
        routes=ROUTES.routes,
    )
    app.state.service = service
    app.state.settings = settings
    app.state.feed = EventFeed(
        service, poll_seconds=settings.poll_seconds, heartbeat_seconds=settings.heartbeat_seconds
    )
    app.state.open_work = OpenWorkWatch(service, poll_seconds=settings.poll_seconds)
    app.state.handed_out = HandedOut(settings.signed_models)
    app.state.streams = Shares(settings.event_streams, settings.event_streams_per_key)
    app.state.limiters = {}
    app.state.pool = pool
    app.state.assets = Assets()
    app.mount("/static", app.state.assets, name="static")
    app.state.authenticator = Authenticator(settings, service)
    app.state.requests = RequestMetrics()
    if pool is not None:
        app.add_middleware(ComputeMiddleware, pool=pool, settings=settings)
    if door:
        app.add_middleware(Intake, settings=settings)  # inside the gate, which knows whose bytes they are
        app.add_middleware(Gate, settings=settings, authenticator=app.state.authenticator)
        app.add_middleware(Observer, metrics=app.state.requests)
    install_error_handlers(app, pages=error_page)
    app.openapi = lambda: _openapi(app)  # type: ignore[method-assign]  # the framework's own way to extend the document
    return app


def _version() -> str:
    try:
        return version("geoswarm")
    except PackageNotFoundError:  # a source tree that is not installed
        return "0"


def _openapi(app: FastAPI) -> dict[str, Any]:
    """The OpenAPI 3.1 document with the schema of the problem file, problem details and the ways to give the key."""
    if app.openapi_schema is None:
        document = get_openapi(title=app.title, version=app.version, description=app.description, routes=app.routes)
        components = document.setdefault("components", {})
        schemas = components.setdefault("schemas", {})
        problem = _relocated(problem_schema())
        del problem["$schema"]
        schemas |= problem.pop("$defs", {})
        schemas["Problem"] = problem
        detail = ProblemDetail.model_json_schema(ref_template="#/components/schemas/{model}")
        schemas |= detail.pop("$defs", {})
        schemas["ProblemDetail"] = detail
        brought = Brought.model_json_schema(ref_template="#/components/schemas/{model}")
        schemas |= brought.pop("$defs", {})
        schemas["Brought"] = brought
        components["securitySchemes"] = {
            "bearer": {"type": "http", "scheme": "bearer"},
            "apiKey": {"type": "apiKey", "in": "header", "name": "X-API-Key"},
            "session": {"type": "apiKey", "in": "cookie", "name": SESSION_COOKIE},
        }
        for path, operations in document["paths"].items():
            for method, operation in operations.items():
                keyed = path.startswith(KEYED) and (method.upper(), path) != SIGN_IN
                operation["security"] = [{"bearer": []}, {"apiKey": []}, {"session": []}] if keyed else []
                if "422" in operation["responses"]:  # replaces the framework's own form of errors
                    operation["responses"]["422"]["content"] = {
                        "application/problem+json": {"schema": {"$ref": "#/components/schemas/ProblemDetail"}}
                    }
        schemas.pop("HTTPValidationError", None)
        schemas.pop("ValidationError", None)
        app.openapi_schema = document
    return app.openapi_schema


def _relocated(value: Any) -> Any:
    """A JSON schema whose references point into the components of the OpenAPI document."""
    if isinstance(value, dict):
        return {
            key: inner.replace("#/$defs/", "#/components/schemas/") if key == "$ref" else _relocated(inner)
            for key, inner in value.items()
        }
    return [_relocated(inner) for inner in value] if isinstance(value, list) else value
