"""Admission of clients to robots: their own, and those that are shared with them."""

from dataclasses import replace

from starlette.concurrency import run_in_threadpool

from endpoints.accounts.scoped_user import ScopedUser
from endpoints.rosbridge.connect_request import ConnectRequest
from endpoints.services.services import Services
from endpoints.sharing.access import access_of
from engine.rights.access import Access
from ppaas.errors import NotFound
from storage.records import User
from storage.sharing_records import Share


async def admitted(services: Services, user: User, request: ConnectRequest) -> tuple[ConnectRequest, Access]:
    """Return the request of a client, and the client's rights on the robot.

    A client that may only look neither opens a place nor keeps it open: containers count for the owner of the robot.

    Raises
    ------
    NotFound
        The robot does not exist, or is neither the user's nor shared with the user.
    NotPermitted
        The user or the token has no right to connect in this role.
    """
    owner = request.owner or user.id
    if is_owner(user, owner):
        return request, Access.of_owner(request.robot)
    shares: tuple[Share, ...] = ()
    if owner != user.id:
        try:
            shares = (await run_in_threadpool(services.store.robot, owner, request.robot)).shares
        except NotFound as error:
            raise NotFound("robot", f"{owner}:{request.robot}") from error
    access = access_of(user, owner, request.robot, shares)
    access.check_connect(as_robot=request.role == "robot")
    if owner != user.id:
        limits = (await run_in_threadpool(services.store.user, owner)).limits
        await services.cloud.set_limits(owner, limits)
    opens = request.role == "robot" or access.role != "look"
    return (request if opens else replace(request, hold=False)), access


async def current_access(services: Services, user: User, owner: str, robot: str) -> Access:
    """Return the rights of a connected client now; reads of the store are cached.

    Raises
    ------
    NotFound, NotPermitted
        As ``access_of``.
    Unavailable
        They cannot be read now.
    """
    own = owner == user.id or user.role == "admin"
    shares = () if own else await services.shares.shares(services.store, owner, robot)
    return access_of(user, owner, robot, shares)


def is_owner(user: User, owner: str) -> bool:
    """Return whether a caller is the owner of a robot, with all rights: the token has no scope."""
    return owner == user.id and not isinstance(user, ScopedUser)
