"""Client of a clone's node monitor: registers the robot, takes nodes over, renews their leases, and returns them."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import msgspec

from ppaas.change_log import LogChange
from ppaas.clock import Clock, monotonic
from ppaas.decoding import from_json
from ppaas.errors import PPaaSError
from ppaas.messages import ppaas_msgs
from ppaas.messages.base.message import Empty, Message, ServiceType
from robots.client.robot_client import RobotClient
from robots.onboard.computer import Computer
from robots.onboard.executor import protocol

UNCHANGED = LogChange([], [])
"""Change of a log that changes nothing."""

SMALL, LARGE = 0, 256 << 10
"""Sizes of the probes [bytes]: the small one measures the round trip, the large one the bandwidth."""

ROUNDS = 5
"""Number of small probes; the fastest counts."""


class _LinkMeasure(NamedTuple):
    """Result of a measurement.

    Attributes
    ----------
    rtt : float
        Round-trip time, the shortest of several [s].
    bandwidth : float
        Bandwidth from the cloud to the robot [bytes/s].
    """

    rtt: float
    bandwidth: float


async def _measure_link(client: RobotClient, clock: Clock = monotonic) -> _LinkMeasure:
    """Measure the link of a connected client.

    Raises
    ------
    PPaaSError
        The cloud did not answer.
    """

    async def probe(size: int) -> float:
        began = clock()
        answer = await client.call(
            "node_monitor/probe_link", ppaas_msgs.ProbeLink, ppaas_msgs.ProbeLinkRequest(size), timeout=30.0
        )
        if not (isinstance(answer, ppaas_msgs.ProbeLinkResponse) and len(answer.data) == size):
            raise PPaaSError(f"node_monitor/probe_link did not return the {size} bytes requested")
        return clock() - began

    rtt = min([await probe(SMALL) for _ in range(ROUNDS)])
    # The extra time of the large probe is its transfer time; on a local link that is close to zero.
    return _LinkMeasure(rtt, LARGE / max(await probe(LARGE) - rtt, 1e-4))


@dataclass(frozen=True)
class NodeSnapshot:
    """State of a node, with the fingerprints of the guaranteed messages that it had received by then.

    Parameters
    ----------
    state : str
        Checkpoint as the node wrote it.
    heard : list of str, optional
        Fingerprints of the messages.
    log : LogChange
        Change of its log that is not reported yet.
    """

    state: str = ""
    heard: list[str] = field(default_factory=list)
    log: LogChange = UNCHANGED


class NodeMonitorClient:
    """Calls the services of the node monitor.

    Parameters
    ----------
    client : RobotClient
        Connected client of the robot.
    computer : Computer
        The robot's computer.
    nodes : sequence of str
        Nodes that the computer can run.
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
        """Register this robot; return the configuration of its clone.

        The link is measured once; later registrations report the round-trip time of the last lease renewal.
        """
        if self._robot is None:
            link, computer = await _measure_link(self._client, self._clock), self._computer
            self._robot, self._round_trip = (
                ppaas_msgs.TellRobotRequest(
                    computer.cores, computer.clock, computer.benchmark, link.rtt, link.bandwidth, self._nodes
                ),
                link.rtt,
            )
        request = msgspec.structs.replace(self._robot, rtt=self._round_trip)
        answer = await self._call("tell_robot", ppaas_msgs.TellRobot, request)
        assert isinstance(answer, ppaas_msgs.TellRobotResponse)
        return from_json(answer.config, protocol.CloneConfig)

    async def run_node(self, node: str, home: str) -> ppaas_msgs.NodeHome:
        """Request a home for a node, empty for the best; return its current and its wanted home.

        Raises
        ------
        NotFound
            The clone has no such node.
        InvalidParameter
            There is no such home.
        """
        answer = await self._call("run_node", ppaas_msgs.RunNode, ppaas_msgs.RunNodeRequest(node, home))
        assert isinstance(answer, ppaas_msgs.NodeHome)
        return answer

    async def list_nodes(self) -> list[ppaas_msgs.NodeHome]:
        """Return the current and the wanted home of each node."""
        answer = await self._call("list_nodes", ppaas_msgs.ListNodes, Empty())
        assert isinstance(answer, ppaas_msgs.NodeHomes)
        return answer.nodes

    async def take_node(self, node: str) -> ppaas_msgs.HoldNodeResponse:
        """Take a node over; return its lease and its checkpoint."""
        answer = await self._call("hold_node", ppaas_msgs.HoldNode, ppaas_msgs.HoldNodeRequest(node))
        assert isinstance(answer, ppaas_msgs.HoldNodeResponse)
        return answer

    async def hold_node(
        self, node: str, lease: int, state: protocol.NodeReport, heard: list[str]
    ) -> ppaas_msgs.HoldNodeResponse:
        """Renew the lease of a node with its state and received messages; also measures the round-trip time."""
        log = [ppaas_msgs.LogPart(*row) for row in state.log]
        request = ppaas_msgs.HoldNodeRequest(
            node, lease, state.state, state.seconds, self._round_trip, heard, log, state.obsolete
        )
        began = self._clock()
        answer = await self._call("hold_node", ppaas_msgs.HoldNode, request)
        self._round_trip = self._clock() - began
        assert isinstance(answer, ppaas_msgs.HoldNodeResponse)
        return answer

    async def give_node(self, node: str, lease: int, snapshot: NodeSnapshot | None = None, failure: str = "") -> None:
        """Return a node to the cloud with its snapshot, or with the reason why it cannot run here."""
        last = snapshot or NodeSnapshot()
        log = [ppaas_msgs.LogPart(*entry) for entry in last.log.entries]
        request = ppaas_msgs.GiveNodeRequest(node, lease, last.state, failure, last.heard, log, last.log.obsolete)
        await self._call("give_node", ppaas_msgs.GiveNode, request)

    async def _call(self, service: str, kind: ServiceType, request: Message) -> Message:
        return await self._client.call(f"node_monitor/{service}", kind, request)
