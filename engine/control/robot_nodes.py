"""Calls of the clones of robots for REST: homes of their nodes, and the maps that they make."""

from collections.abc import Awaitable, Callable

from engine.links.place_link import PlaceLink
from engine.protocols.robot_link import LINK_FACTS
from ppaas.decoding import from_json
from ppaas.diagnosis.observations.facts import LinkFacts, Observations, observations_from_json
from ppaas.errors import Conflict, NotFound, Unavailable
from ppaas.messages import decode, encode
from ppaas.messages.base.message import Empty, Message
from ppaas.messages.health.watching import ObserveRequest, ObserveResponse, RecorderState
from ppaas.messages.octomap_msgs import GetOctomapFileRequest, GetOctomapFileResponse
from ppaas.messages.ppaas_msgs import NodeHome, NodeHomes, RunNodeRequest
from ppaas.messages.slam_toolbox import (
    GetPoseGraphRequest,
    GetPoseGraphResponse,
    UseJointMapRequest,
    UseJointMapResponse,
)

ANSWER_TIMEOUT = 10.0
"""Time limit of a call of the node monitor [s], which normally answers within milliseconds."""

PlaceOf = Callable[[str, str], Awaitable[PlaceLink | None]]
"""Returns the link of the place of a user's robot; None if it has none."""

MAP_TIMEOUT = 60.0
"""Time limit of a call for a page of a map [s]; the first one packs the whole map."""


class RobotNodes:
    """Calls the node monitors of connected robots, and the nodes that make their maps.

    Parameters
    ----------
    place_of : callable
        Returns the link of the place of a robot; None if it has none.
    """

    def __init__(self, place_of: PlaceOf) -> None:
        self._place_of = place_of

    async def homes(self, user: str, robot: str) -> list[NodeHome]:
        """Return the home of each node of a robot, and the reason for it.

        Raises
        ------
        Unavailable
            The robot has no container now.
        """
        return decode(NodeHomes, await self._ask(user, robot, "list_nodes", Empty())).nodes

    async def run(self, user: str, robot: str, node: str, home: str) -> NodeHome:
        """Move a node to the requested home, or to the best one; return its home as the node monitor reports it.

        Parameters
        ----------
        user, robot : str
            User and robot of the node.
        node : str
            Name of the node.
        home : str
            ``cloud``, ``robot``, or empty for the best.

        Raises
        ------
        NotFound
            The robot's clone has no such node.
        Unavailable
            The robot has no container now.
        """
        return decode(NodeHome, await self._ask(user, robot, "run_node", RunNodeRequest(node, home)))

    async def map(self, user: str, robot: str, offset: int) -> GetPoseGraphResponse:
        """Return a page of the pose graph of the map that a robot makes; −1 returns its numbers.

        Raises
        ------
        Unavailable
            The robot has no container now, or no map yet.
        Conflict
            The robot does not make a map.
        """
        place = await self._place(user, robot)
        try:
            answer = await place.call("pose_graph", encode(GetPoseGraphRequest(offset)), MAP_TIMEOUT)
        except NotFound as error:
            raise Conflict(
                f'robot {robot!r} drives on a published map and makes none: set "map": "new:NAME" in its file'
            ) from error
        return decode(GetPoseGraphResponse, answer)

    async def use_joint_map(self, user: str, robot: str, page: UseJointMapRequest) -> UseJointMapResponse:
        """Send a page of a joint map to a robot that makes a map; after the last one it goes on with the joint map.

        Raises
        ------
        Unavailable
            The robot has no container or no map now.
        Conflict
            The joint map does not contain the robot's own map.
        """
        place = await self._place(user, robot)
        answer = await place.call("grid_slam/use_joint_map", encode(page), MAP_TIMEOUT)
        return decode(UseJointMapResponse, answer)

    async def octomap(self, user: str, robot: str, request: GetOctomapFileRequest) -> GetOctomapFileResponse:
        """Return a page of the octomap that a robot makes; an empty one if it makes none.

        Raises
        ------
        Unavailable
            The robot has no container now.
        """
        place = await self._place(user, robot)
        try:
            answer = await place.call("octomap_server/file", encode(request), MAP_TIMEOUT)
        except NotFound:
            return GetOctomapFileResponse()
        return decode(GetOctomapFileResponse, answer)

    async def observe(self, user: str, robot: str, seconds: float) -> Observations:
        """Return what the cloud observes of a robot, once its clone has watched it for a time [s].

        A robot that is not connected is not watched; only its connection is described.

        Raises
        ------
        Unavailable
            The robot has no container now.
        """
        place = await self._place(user, robot)
        link = await self._link_facts(place)
        if not link.robots:
            return Observations(seconds=0.0, link=link)
        answer = await place.call("diagnostics/observe", encode(ObserveRequest(seconds)), seconds + ANSWER_TIMEOUT)
        seen = observations_from_json(decode(ObserveResponse, answer).observations)
        seen.link = await self._link_facts(place)
        return seen

    @staticmethod
    async def _link_facts(place: PlaceLink) -> LinkFacts:
        return from_json(await place.call(LINK_FACTS, b"{}", ANSWER_TIMEOUT), LinkFacts)

    async def recorder(self, user: str, robot: str, service: str, request: Message) -> RecorderState:
        """Call a service of the recorder of a robot, ``start``, ``stop`` or ``state``; return its state.

        Raises
        ------
        Conflict
            A recording is in progress.
        InvalidParameter
            The time or the topics are invalid.
        Unavailable
            The robot has no container now.
        """
        place = await self._place(user, robot)
        return decode(RecorderState, await place.call(f"recorder/{service}", encode(request), ANSWER_TIMEOUT))

    async def _ask(self, user: str, robot: str, service: str, request: Message) -> bytes:
        return await (await self._place(user, robot)).call(f"node_monitor/{service}", encode(request), ANSWER_TIMEOUT)

    async def _place(self, user: str, robot: str) -> PlaceLink:
        place = await self._place_of(user, robot)
        if place is None:
            raise Unavailable(f"robot {robot!r} has no container now: its nodes run while it is connected")
        return place
