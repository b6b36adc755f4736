"""Measurement of the link to the cloud: round-trip time and bandwidth."""

from typing import NamedTuple

from ppaas.clock import Clock, monotonic
from ppaas.errors import PPaaSError
from ppaas.messages import ppaas_msgs
from robots.client.robot_client import RobotClient

SMALL, LARGE = 0, 256 << 10
"""Sizes of the probes [bytes]: the small one measures the round trip, the large one the bandwidth."""

ROUNDS = 5
"""Number of small probes; the fastest counts."""


class LinkMeasure(NamedTuple):
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


async def measure_link(client: RobotClient, clock: Clock = monotonic) -> LinkMeasure:
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
    return LinkMeasure(rtt, LARGE / max(await probe(LARGE) - rtt, 1e-4))
