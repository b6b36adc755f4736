"""Homes of the nodes of robots, for REST: queried and changed by each clone's node monitor."""

from engine.master.places import robot_key
from engine.service.master_driver import MasterDriver
from ppaas.errors import Unavailable
from ppaas.messages import decode, encode
from ppaas.messages.message import Empty, Message
from ppaas.messages.ppaas_msgs import NodeHome, NodeHomes, RunNodeRequest

ANSWER_TIMEOUT = 10.0
"""Time limit of a call of the node monitor [s], which normally answers within milliseconds."""


class RobotNodes:
    """Calls the node monitors of connected robots.

    Parameters
    ----------
    service : MasterDriver
        Has the links of the places.
    """

    def __init__(self, service: MasterDriver) -> None:
        self._service = service

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

    async def _ask(self, user: str, robot: str, service: str, request: Message) -> bytes:
        place = self._service.place(robot_key(user, robot))
        if place is None:
            raise Unavailable(f"robot {robot!r} has no container now: its nodes run while it is connected")
        return await place.call(f"node_monitor/{service}", encode(request), ANSWER_TIMEOUT)
