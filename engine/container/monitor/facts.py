"""Facts on which the node monitor bases its verdicts: the robot's computer, the link, and each node."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

import msgspec

from ppaas.errors import InvalidInput
from ppaas.nodes.base import Demands

Home = Literal["cloud", "robot"]

REFERENCE_CLOCK = 1.5
"""Clock of a Raspberry Pi 4 [GHz]."""


class RobotComputer(msgspec.Struct, frozen=True):
    """Computer of a robot, on which nodes may run.

    Parameters
    ----------
    cores : int
        Number of cores.
    clock : float
        Clock of the processor [GHz].
    benchmark : float
        Measured speed of one core in a fixed kernel, relative to a Raspberry Pi 4.
    nodes : tuple of str
        Names of the nodes that it can run.

    Raises
    ------
    InvalidInput
        A number is not positive and finite.
    """

    cores: int
    clock: float
    benchmark: float
    nodes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        _check_positive(cores=self.cores, clock=self.clock, benchmark=self.benchmark)

    @property
    def power(self) -> float:
        """Power [cores of a Raspberry Pi 4]: cores times the geometric mean of benchmark and relative clock."""
        return self.cores * math.sqrt(self.benchmark * self.clock / REFERENCE_CLOCK)


class NetworkLink(msgspec.Struct, frozen=True):
    """Network link between a robot and the cloud.

    Parameters
    ----------
    rtt : float
        Round-trip time [s].
    bandwidth : float
        Bandwidth [bytes/s].

    Raises
    ------
    InvalidInput
        A number is not positive and finite.
    """

    rtt: float
    bandwidth: float

    def __post_init__(self) -> None:
        _check_positive(rtt=self.rtt, bandwidth=self.bandwidth)


@dataclass(frozen=True, slots=True)
class MonitoredNode:
    """Facts about a node.

    Parameters
    ----------
    name : str
        Name of the node.
    demands : Demands, optional
        Demands that its class declares; None for a node that must stay in the cloud.
    rates : dict of str to float
        Data rate of each topic that it receives over the link while in the cloud [bytes/s], measured if possible.
    cloud_seconds, robot_seconds : float, optional
        Median time to process one input in either home [s].
    taken : float
        Power that other nodes on the robot use already [cores of a Raspberry Pi 4].
    failure : str
        Reason of a recent failure on the robot; empty if there was none.
    """

    name: str
    demands: Demands | None
    rates: Mapping[str, float] = field(default_factory=dict)
    cloud_seconds: float | None = None
    robot_seconds: float | None = None
    taken: float = 0.0
    failure: str = ""


def _check_positive(**numbers: float) -> None:
    for name, number in numbers.items():
        if not (math.isfinite(number) and number > 0.0):
            raise InvalidInput(f"{name} must be a positive number, not {number}: measure it again")
