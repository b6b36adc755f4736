"""Exploration of a clone: the node ``explore`` of a robot that makes a map."""

from collections.abc import Callable
from functools import partial

import msgspec

from ppaas.clone.node_parameters import NodeParameters
from ppaas.costmap.build_layers import build_layers
from ppaas.costmap.global_parameters import CostParameters
from ppaas.exploration.parameters import ExploreParameters
from ppaas.nodes.base import Context, Node
from ppaas.nodes.frames import FrameNames
from ppaas.robot_model.known_models import RobotModel

EXPLORE = "explore"
"""Name of the node."""


def exploring(
    given: NodeParameters, body: RobotModel, costs: CostParameters, names: FrameNames, *, maps: bool
) -> dict[str, Callable[[Context], Node]]:
    """Return the maker of the node if the robot makes a map; else its parameters are checked, but not used.

    Raises
    ------
    InvalidParameter
        A parameter is unknown or invalid.
    """
    if not maps:
        if given.has(EXPLORE):
            given.check(ExploreParameters, EXPLORE)
        return {}
    # Imported only here, so that not every container loads its kernels.
    from ppaas.nodes.explore.node import ExploreNode  # noqa: PLC0415

    parameters = given.read(ExploreParameters, EXPLORE)
    build = partial(build_layers, robot_radius=body.robot_radius, **msgspec.structs.asdict(costs))
    return {EXPLORE: lambda context: ExploreNode(context, parameters, build, names)}
