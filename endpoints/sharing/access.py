"""Access of a caller to a robot: by the shares of the robot and the scope of the caller's token, and route by route.

No route reveals what the robot would not send a caller: each needs the topics whose content it returns.
"""

from collections.abc import Iterable, Mapping
from typing import Final

from endpoints.accounts.tokens import ScopedUser
from engine.rights.access import OWNED, Access, only_reads
from engine.rights.globs import is_in_scope
from ppaas.errors import NotFound, NotPermitted
from ppaas.nodes import topics
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


GOALS: Final = (topics.MOVE_BASE_GOAL.name, topics.MOVE_BASE_STATUS.name)
LOCALIZATION: Final = (topics.AMCL_STATUS.name, topics.GRID_SLAM_STATUS.name)
DESCRIPTION: Final = (topics.ROBOT_DESCRIPTION.name,)
PARAMETERS: Final = ("rosapi/get_param",)

TOLD: Final[Mapping[str, tuple[str, ...]]] = {
    "show_robot": (),  # the parts `urdf` and `parameters` need more
    "fetch_urdf": DESCRIPTION,
    "list_nodes": (topics.NODE_HOMES.name,),
    "show_robot_map": (topics.MAP.name,),
    "fetch_robot_posegraph": ("pose_graph",),
    "show_state": (topics.AMCL_POSE.name,),  # the parts `goals` and `localization` need more
    "list_goals": GOALS,
    "show_goal": GOALS,
    "diagnose_robot": (topics.DIAGNOSTICS.name,),
    "show_recorder": ("recorder/state",),
    "list_recordings": (),
    "show_recording": (),
    "fetch_recording": (),  # the file has the topics alone that the caller may subscribe to
    "unshare_robot": (),
}
"""Topics, and services that only read, by the name of the route; a caller needs the right to all of them."""


def check_told(access: Access, route: str) -> None:
    """Raise ``NotPermitted`` unless a caller may read all that a route answers with."""
    for name in TOLD[route]:
        if only_reads(name):
            access.check_call(name)
        else:
            access.check_subscribe(name)


def may_hear(access: Access, names: tuple[str, ...]) -> bool:
    """Return whether a caller may read some topics, and services that only read."""
    return access.is_full or all(access.may_read(name) for name in names)


def in_words(names: tuple[str, ...]) -> str:
    """Return names of topics and services for a text."""
    return " and ".join(f"`{name}`" for name in names)
