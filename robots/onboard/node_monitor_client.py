"""Client of a clone's node monitor: tells it of the robot, and takes, holds and gives back nodes."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import msgspec

from ppaas.clock import Clock
from ppaas.messages import ppaas_msgs
from ppaas.messages.message import Empty, Message, ServiceType
from robots.client.robot_client import RobotClient
from robots.onboard.computer import Computer
from robots.onboard.executor import protocol
from robots.onboard.link_probe import measure_link


@dataclass(frozen=True)
class Known:
    """State of a node, and the fingerprints of what must arrive and had reached the node before that state.

    Parameters
    ----------
    state : str
        As the node wrote it.
    heard : list of str, optional
        Fingerprints of messages.
    """

    state: str = ""
    heard: list[str] = field(default_factory=list)


class NodeMonitorClient:
    """Calls the services of the node monitor.

    Parameters
    ----------
    client : RobotClient
        Of the robot, open.
    computer : Computer
        What it has to run nodes on.
    nodes : sequence of str
        Those that it can run.
    clock : callable
        Monotonic seconds.
    """

    def __init__(self, client: RobotClient, computer: Computer, nodes: Sequence[str], clock: Clock) -> None:
        self._client = client
        self._computer = computer
        self._nodes = list(nodes)
        self._clock = clock
        self._round_trip = 0.0
        self._robot: ppaas_msgs.TellRobotRequest | None = None

    async def tell_robot(self) -> protocol.CloneConfig:
        """Say what this robot is; return the settings of its clone.

        The link is measured once; its round trip is that of the last call that was measured.
        """
        if self._robot is None:
            link, computer = await measure_link(self._client, self._clock), self._computer
            self._robot, self._round_trip = (
                ppaas_msgs.TellRobotRequest(
                    computer.cores, computer.clock, computer.benchmark, link.rtt, link.bandwidth, self._nodes
                ),
                link.rtt,
            )
        told = msgspec.structs.replace(self._robot, rtt=self._round_trip)
        answer = await self._call("tell_robot", ppaas_msgs.TellRobot, told)
        assert isinstance(answer, ppaas_msgs.TellRobotResponse)
        return msgspec.json.decode(answer.config, type=protocol.CloneConfig)

    async def run_node(self, node: str, home: str) -> ppaas_msgs.NodeHome:
        """Ask for a node to run somewhere, or where the monitor finds best; return where it is and shall be.

        Raises
        ------
        NotFound
            No such node.
        InvalidParameter
            No such place.
        """
        answer = await self._call("run_node", ppaas_msgs.RunNode, ppaas_msgs.RunNodeRequest(node, home))
        assert isinstance(answer, ppaas_msgs.NodeHome)
        return answer

    async def list_nodes(self) -> list[ppaas_msgs.NodeHome]:
        """Return where each node is and shall be."""
        answer = await self._call("list_nodes", ppaas_msgs.ListNodes, Empty())
        assert isinstance(answer, ppaas_msgs.NodeHomes)
        return answer.nodes

    async def take_node(self, node: str) -> ppaas_msgs.HoldNodeResponse:
        """Take a node over; return its lease and its state."""
        answer = await self._call("hold_node", ppaas_msgs.HoldNode, ppaas_msgs.HoldNodeRequest(node))
        assert isinstance(answer, ppaas_msgs.HoldNodeResponse)
        return answer

    async def hold_node(
        self, node: str, lease: int, state: protocol.NodeState, heard: list[str]
    ) -> ppaas_msgs.HoldNodeResponse:
        """Renew the lease of a node with its state and what it has heard; the call measures the round trip."""
        told = ppaas_msgs.HoldNodeRequest(node, lease, state.state, state.seconds, self._round_trip, heard)
        began = self._clock()
        answer = await self._call("hold_node", ppaas_msgs.HoldNode, told)
        self._round_trip = self._clock() - began
        assert isinstance(answer, ppaas_msgs.HoldNodeResponse)
        return answer

    async def give_node(self, node: str, lease: int, known: Known | None = None, failure: str = "") -> None:
        """Give a node back with what is known of it, or say why it cannot run here."""
        last = known or Known()
        told = ppaas_msgs.GiveNodeRequest(node, lease, last.state, failure, last.heard)
        await self._call("give_node", ppaas_msgs.GiveNode, told)

    async def _call(self, service: str, kind: ServiceType, request: Message) -> Message:
        return await self._client.call(f"node_monitor/{service}", kind, request)
