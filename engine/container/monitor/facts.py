"""What the node monitor knows before it gives a verdict."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

import msgspec

from ppaas.errors import InvalidInput
from ppaas.nodes.base import Demands

Home = Literal["cloud", "robot"]

REFERENCE_CLOCK = 1.5
"""Of a Raspberry Pi 4 [GHz]."""


class Robot(msgspec.Struct, frozen=True):
    """What a robot has to run nodes on.

    Parameters
    ----------
    cores : int
        Of its processor.
    clock : float
        [GHz].
    benchmark : float
        How fast one core was in a fixed kernel, where a Raspberry Pi 4 is 1.
    nodes : tuple of str
        Names of those that it can run.

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
        """What it is worth, in cores of a Raspberry Pi 4: what was measured and what is promised count alike."""
        return self.cores * math.sqrt(self.benchmark * self.clock / REFERENCE_CLOCK)


class Link(msgspec.Struct, frozen=True):
    """What lies between a robot and the cloud.

    Parameters
    ----------
    rtt : float
        There and back [s].
    bandwidth : float
        [bytes/s].

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
class NodeFacts:
    """What is known of a node.

    Parameters
    ----------
    name : str
        Of the node.
    demands : Demands, optional
        What its class declares; None for one that stays in the cloud.
    rates : dict of str to float
        What comes to it over the link while it is in the cloud, by topic [bytes/s]: measured where it was.
    cloud_seconds, robot_seconds : float, optional
        What it took for each thing that it was told, in either home [s].
    taken : float
        What other nodes take of the robot already, in cores of a Raspberry Pi 4.
    failure : str
        Why it could not be run on the robot a moment ago; empty if it could.
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
            raise InvalidInput(f"{name} must be a positive number, not {number}: measure it anew")
