"""FastAPI application of the REST service, without the robot WebSocket."""

from typing import Any, Final

from fastapi import APIRouter, Depends, FastAPI
from fastapi.routing import APIRoute
from starlette.types import Receive, Scope, Send

from endpoints.audit.requests import AuditedRequests
from endpoints.dashboard.pages import add_dashboard
from endpoints.documentation.site import BUILT, add_documentation
from endpoints.http.body_limit import BodyLimit, BodyLimits
from endpoints.http.front import ApplicationFront, HeadRequests
from endpoints.http.front_settings import FrontSettings
from endpoints.http.problems import add_problem_handlers
from endpoints.resources.services import Services
from endpoints.rest import tasks, traffic
from endpoints.rest.buildings import building_plans, building_state, buildings
from endpoints.rest.cluster import acknowledgements, audit, containers, endpoints, health, machines, retention
from endpoints.rest.dependencies import single_query_values
from endpoints.rest.maps import map_cells, map_merge, map_reviews, map_versions, map_zones, maps
from endpoints.rest.openapi import EVERYWHERE, TAGS, add_viewer, describe, operation_id
from endpoints.rest.people import people, people_history
from endpoints.rest.plans import (
    evaluation,
    fleet_plans,
    plan_database,
    planners,
    planning,
    stored_plans,
)
from endpoints.rest.plans.fast_path import PlanFastPath
from endpoints.rest.recordings import robot_recordings
from endpoints.rest.robots import (
    models,
    robot_diagnosis,
    robot_goals,
    robot_map,
    robot_moves,
    robot_shares,
    robot_stops,
    robot_urdf,
    robots,
)
from endpoints.rest.users import groups, oidc, tokens, users
from endpoints.rest.webhooks import webhook_deliveries, webhooks
from ppaas import __version__

PREFIX = "/v1"
"""Prefix of the paths of the REST service."""

DESCRIPTION = """
Path planning as a service. Log in with `POST /v1/tokens`, publish a map with `POST /v1/maps`, and request a path with
`POST /v1/maps/{map_id}/plans`. A robot registers with `PUT /v1/robots/{robot_id}` and then opens a WebSocket at
`/?robot=ID`, speaking rosbridge.

Lists are paginated: each page has up to `limit` items and, in `next`, the `cursor` of the following page or null.

Lengths are in metres, angles in radians, times in seconds. Errors are problems of RFC 9457 with a stable `type`.
"""

RESOURCES = (
    planning,
    fleet_plans,
    tokens,
    oidc,
    users,
    groups,
    maps,
    map_versions,
    map_reviews,
    map_merge,
    map_cells,
    map_zones,
    buildings,
    building_plans,
    building_state,
    people,
    people_history,
    traffic,
    tasks,
    evaluation,
    models,
    planners,
    robots,
    robot_urdf,
    robot_map,
    robot_goals,
    robot_moves,
    robot_stops,
    robot_diagnosis,
    robot_shares,
    robot_recordings,
    plan_database,
    stored_plans,
    machines,
    endpoints,
    containers,
    health,
    acknowledgements,
    audit,
    retention,
    webhooks,
    webhook_deliveries,
)

_service = APIRouter(responses=EVERYWHERE, generate_unique_id_function=operation_id)
for _resource in RESOURCES:
    _service.include_router(_resource.router, prefix=PREFIX, dependencies=[Depends(single_query_values)])

ROUTES: Final = tuple(_service.routes)
"""Routes of the REST service, which all applications share.

FastAPI analyses the parameters of a route when a request first reaches it. Routes that each application included for
itself would be analysed again by each, which takes a tenth of a second.
"""


OPERATIONS: Final = tuple(
    (f"{PREFIX}{route.path}", route.methods or ())
    for resource in RESOURCES
    for route in resource.router.routes
    if isinstance(route, APIRoute)
)
"""Paths of the REST service, with the methods of each route."""


LOGINS = (tokens.PATH, *oidc.PATHS)
"""Paths whose bodies are read before their sender is authenticated."""


class Application(FastAPI):
    """FastAPI application behind the limits of bodies and the fast path of path requests.

    Both run before FastAPI's own middleware, which takes longer than they do.

    Attributes
    ----------
    front : ApplicationFront
        Front of the application.
    """

    def __init__(self, services: Services, settings: FrontSettings, **options: Any) -> None:
        super().__init__(**options)
        limits = services.limits
        posts = {
            f"{PREFIX}{maps.router.prefix}": BodyLimits(limits.max_upload, limits.max_upload_seconds),
            **{f"{PREFIX}{path}": BodyLimits(limits.max_login, limits.max_body_seconds) for path in LOGINS},
        }
        fast_path = PlanFastPath(super().__call__, prefix=PREFIX, services=services)
        bodies = BodyLimit(fast_path, BodyLimits(limits.max_body, limits.max_body_seconds), posts)
        self.front = ApplicationFront(HeadRequests(bodies), settings, private=PREFIX)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve one request or connection."""
        await self.front(scope, receive, send)


def description() -> dict[str, Any]:
    """Return the OpenAPI document of the REST service."""
    app = FastAPI(**_options())
    describe(app)
    return app.openapi()


def _options() -> dict[str, Any]:
    return {
        "title": "PPaaS",
        "summary": "Path Planning as a Service",
        "description": DESCRIPTION,
        "version": __version__,
        "routes": list(ROUTES),
        "openapi_tags": TAGS,
        "servers": [{"url": "."}],  # relative to the document, so also below a path of a proxy
        "redirect_slashes": False,
        "openapi_url": None,  # `describe` serves it
        "docs_url": None,
        "redoc_url": None,
    }


def create_app(services: Services, settings: FrontSettings | None = None) -> Application:
    """Return the application for these services; it neither starts nor closes them."""
    settings = settings or FrontSettings()
    app = Application(services, settings, **_options())
    describe(app)
    app.state.services = services
    add_viewer(app)
    add_problem_handlers(app, OPERATIONS)
    app.add_middleware(AuditedRequests, log=services.audit)
    add_dashboard(app)
    add_documentation(app, settings.docs_site or BUILT)
    return app
