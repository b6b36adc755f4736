"""How far away the cloud is: there and back, and bytes a second."""

from typing import NamedTuple

from ppaas.clock import Clock, monotonic
from ppaas.errors import PPaaSError
from ppaas.messages import ppaas_msgs
from robots.client.robot_client import RobotClient

SMALL, LARGE = 0, 256 << 10
"""Bytes that are asked for: by the one how long it takes is measured, by the other how much comes in a second."""

ROUNDS = 5


class LinkMeasure(NamedTuple):
    """What was measured.

    Attributes
    ----------
    rtt : float
        There and back [s], the shortest of some.
    bandwidth : float
        From the cloud to the robot [bytes/s].
    """

    rtt: float
    bandwidth: float


async def measure_link(client: RobotClient, clock: Clock = monotonic) -> LinkMeasure:
    """Measure the link of a client that is connected.

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
            raise PPaaSError(f"a probe of {size} bytes was asked for, and something else came")
        return clock() - began

    rtt = min([await probe(SMALL) for _ in range(ROUNDS)])
    # What the large one takes beyond the small one is the bytes; on a link of this machine there is next to nothing.
    return LinkMeasure(rtt, LARGE / max(await probe(LARGE) - rtt, 1e-4))
