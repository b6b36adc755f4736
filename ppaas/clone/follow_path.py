"""Robots that follow paths themselves: their parameters, and Move Base for them."""

from collections.abc import Callable
from typing import Any

from ppaas.clone.node_parameters import NodeParameters
from ppaas.errors import InvalidParameter
from ppaas.nodes.base import Context
from ppaas.nodes.follow_path.node import DEFAULTS, PathFollowingNode
from ppaas.nodes.follow_path.path_follower import FollowPathParameters, PathFollower
from ppaas.nodes.move_base.node import MoveBaseNode

FOLLOW_PATH = PathFollower.name
"""Name of the parameters; a robot that has them, even empty ones, follows paths itself."""


def move_base_defaults(given: NodeParameters) -> dict[str, Any]:
    """Return the parameters of Move Base that differ for a robot that follows paths itself."""
    return dict(DEFAULTS) if given.has(FOLLOW_PATH) else {}


def move_base_kind(given: NodeParameters, usual: type[MoveBaseNode], *, maps: bool) -> Callable[..., MoveBaseNode]:
    """Return the maker of Move Base for a robot that follows paths itself, and for other robots the usual class.

    Parameters
    ----------
    given : NodeParameters
    usual : type of MoveBaseNode
    maps : bool
        Whether the robot makes a map.

    Raises
    ------
    InvalidParameter
        A parameter is unknown or invalid, or a robot that follows paths makes a map.
    """
    if not given.has(FOLLOW_PATH):
        return usual
    if maps:
        raise InvalidParameter(f"a robot with parameters for {FOLLOW_PATH!r} needs a map: it does not make one")
    parameters = given.read(FollowPathParameters, FOLLOW_PATH)

    def make(context: Context, **options: Any) -> MoveBaseNode:
        """Make the node; the local planner of the options is not used."""
        return PathFollowingNode(context, **options | {"controller": PathFollower(context, parameters)})

    return make
