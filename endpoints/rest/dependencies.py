"""Dependencies of the routes: the services, the user, and the maps and robots that a user may use."""

from collections import Counter
from collections.abc import Awaitable, Callable
from typing import Annotated

from fastapi import Depends, Request
from fastapi.security import HTTPAuthorizationCredentials, HTTPBearer
from starlette.concurrency import run_in_threadpool

from endpoints.accounts.authentication import authenticate, caller_of
from endpoints.accounts.tokens import ScopedUser
from endpoints.resources.services import Services
from endpoints.rest.names import RobotAddress
from endpoints.rest.paging import Paging
from endpoints.sharing.access import access_of, check_told
from endpoints.sharing.shared_robots import ReachedRobot, reach, reads_itself, shows_map
from engine.rights.globs import split_address
from ppaas.errors import Damaged, InvalidParameter, NotFound, NotPermitted
from storage.records import MapRecord, User
from storage.sharing_records import ShareRole

_bearer = HTTPBearer(auto_error=False, description="Token from POST /v1/tokens.")


async def services_of(request: Request) -> Services:  # async: FastAPI calls other functions in a thread
    """Return the services of the application."""
    services = request.app.state.services
    assert isinstance(services, Services)
    return services


Provided = Annotated[Services, Depends(services_of)]


async def single_query_values(request: Request) -> None:
    """Raise ``InvalidParameter`` if a query parameter is given more than once: no route takes a list of values."""
    counts = Counter(name for name, _ in request.query_params.multi_items())
    for name, count in counts.items():
        if count > 1:
            raise InvalidParameter(f"query parameter {name!r} is given {count} times: give it once")


async def any_user(
    request: Request,
    services: Provided,
    _documented: Annotated[HTTPAuthorizationCredentials | None, Depends(_bearer)],
) -> User:
    """Return the user of a request, whose own limits apply from now on; ``NotAuthenticated`` without a valid token.

    It is a `ScopedUser` if the token has a scope, which the route must respect.
    """
    # Again, also after a route that did so before it read the body: the token may have been revoked meanwhile.
    user = await authenticate(request, services.accounts)
    await services.cloud.set_limits(user.id, user.limits)
    return user


AnyCaller = Annotated[User, Depends(any_user)]
"""Caller of a route that respects scopes of tokens."""


def check_unscoped(user: User) -> None:
    """Raise ``NotPermitted`` if the token of a caller is for some robots only."""
    if isinstance(user, ScopedUser):
        raise NotPermitted(
            f"this token is for the robots {', '.join(user.scope.robots)} only: log in and use a token without a scope"
        )


async def current_user(user: AnyCaller) -> User:
    """Return the user of a request; ``NotPermitted`` if the token is for some robots only."""
    check_unscoped(user)
    return user


Caller = Annotated[User, Depends(current_user)]


def used_token(request: Request) -> str:
    """Return the id of the token of a request that was authenticated."""
    caller = caller_of(request.scope)
    assert caller is not None
    return caller.token


async def current_admin(user: Caller) -> User:
    """Return the user of a request; ``NotPermitted`` unless an administrator."""
    if user.role != "admin":
        raise NotPermitted("only an administrator may do this")
    return user


Admin = Annotated[User, Depends(current_admin)]
Paged = Annotated[Paging, Depends()]


async def readable_head(services: Services, user: User, map_id: str) -> MapRecord:
    """Return a map without its files; ``NotFound`` also if the user may not read it, so that ids are not revealed."""
    head = await services.map_cache.head(services.map_store, map_id)
    if not reads_itself(user, head) and not await run_in_threadpool(shows_map, services.store, user, head):
        raise NotFound("map", map_id)
    return head


async def owned_head(services: Services, user: User, map_id: str) -> MapRecord:
    """Return the head of a map; ``NotPermitted`` unless the user owns it or is an administrator."""
    head = await readable_head(services, user, map_id)
    if user.role != "admin" and user.id != head.owner:
        raise NotPermitted(f"only the owner of map {map_id!r} may do this")
    return head


async def looked_at(robot_id: RobotAddress, request: Request, services: Provided, user: AnyCaller) -> ReachedRobot:
    """Return the robot of a path; ``NotPermitted`` unless the caller may read what the route answers with (`TOLD`)."""
    robot = await run_in_threadpool(reach, services.store, user, robot_id)
    check_told(robot.access, request.scope["route"].name)
    return robot


def _robot_for(role: ShareRole) -> Callable[..., Awaitable[ReachedRobot]]:
    """Return a dependency that finds the robot of a path; `NotPermitted` unless the caller has a role on it."""

    async def reached(robot_id: RobotAddress, services: Provided, user: AnyCaller) -> ReachedRobot:
        robot = await run_in_threadpool(reach, services.store, user, robot_id)
        robot.access.check_role(role)
        return robot

    return reached


async def removable(robot_id: RobotAddress, services: Provided, user: AnyCaller) -> tuple[str, str]:
    """Return owner and id of the robot of a path, which the caller may remove, also if its record is damaged.

    The shares of a damaged one cannot be read: its owner removes it, or an administrator of the cloud.
    """
    owner, name = split_address(robot_id, user.id)
    try:
        access = (await run_in_threadpool(reach, services.store, user, robot_id)).access
    except Damaged:
        access = access_of(user, owner, name, ())
    access.check_role("administer")
    return owner, name


Looked = Annotated[ReachedRobot, Depends(looked_at)]
Driven = Annotated[ReachedRobot, Depends(_robot_for("drive"))]
Administered = Annotated[ReachedRobot, Depends(_robot_for("administer"))]
Removable = Annotated[tuple[str, str], Depends(removable)]


async def is_in_use(services: Services, map_id: str) -> bool:
    """Return whether containers of robots use a map, also as a mask; those that wait for a robot use it, too."""
    containers = await services.cloud.containers.views(None)
    return any(one.robot is not None and map_id in (one.map.id, *one.masks) for one in containers)
