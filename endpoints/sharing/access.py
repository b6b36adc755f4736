"""Access of a caller to a robot, by the shares of the robot and the scope of the caller's token."""

from collections.abc import Iterable

from endpoints.accounts.scoped_user import ScopedUser
from engine.rights.access import OWNED, Access
from engine.rights.globs import is_in_scope
from ppaas.errors import NotFound, NotPermitted
from storage.records import User
from storage.sharing_records import Share, grantees_of


def access_of(caller: User, owner: str, robot: str, shares: Iterable[Share]) -> Access:
    """Return the access of a caller to a robot.

    Parameters
    ----------
    caller : User
        A `ScopedUser` if the token has a scope.
    owner, robot : str
        User and id of the robot.
    shares : iterable of Share
        Shares of the robot.

    Raises
    ------
    NotFound
        The robot is neither the caller's nor shared with the caller.
    NotPermitted
        The caller's token is not for this robot.
    """
    address = robot if owner == caller.id else f"{owner}:{robot}"
    if owner == caller.id or caller.role == "admin":
        grants: tuple[Share, ...] = (OWNED,)
    else:
        mine = grantees_of(caller.id, caller.groups)
        grants = tuple(share for share in shares if share.to in mine)
    if not grants:
        raise NotFound("robot", address)
    if not isinstance(caller, ScopedUser):
        return Access(address, grants)
    if not is_in_scope(caller.scope, caller.id, owner, robot):
        raise NotPermitted(f"this token is for the robots {', '.join(caller.scope.robots)}, and not for {address!r}")
    return Access(address, grants, caller.scope)
