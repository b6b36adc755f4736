"""Parameters of the node monitor."""

from typing import Annotated, Any, Literal

from msgspec import Meta

from ppaas.errors import InvalidParameter
from ppaas.parameters import Parameters, read_parameters

NAME = "node_monitor"

Criterion = Literal["computation_power", "node_properties", "network_bandwidth"]

CRITERIA: tuple[Criterion, ...] = ("computation_power", "node_properties", "network_bandwidth")

Positive = Annotated[float, Meta(gt=0.0, lt=1e9)]


class NodeMonitorParameters(Parameters, frozen=True):
    """What the verdicts of a robot's node monitor go by; the cloud has a default, a robot's file may say otherwise.

    Parameters
    ----------
    priorities : tuple of str
        The criteria, what counts most first; one that is left out does not count.
    time_critical : tuple of str
        Nodes for which a late answer is as bad as none, beside those that say so themselves.
    weak_power, strong_power : float
        A robot of the one or less is served in the cloud first; one of the other or more can do all itself. In cores
        of a Raspberry Pi 4, which is worth four.
    usable_power : float
        The part of a robot's power that nodes may take.
    usable_bandwidth : float
        The part of a link's bandwidth that nodes in the cloud may take.
    slow_rtt : float
        There and back [s], from which on a link is no way to drive a robot.
    patience : float
        Seconds of silence after which a node on the robot counts as lost, and goes on in the cloud.
    retry_after : float
        Seconds for which a node that failed on the robot stays in the cloud, unless somebody asks.

    Raises
    ------
    InvalidParameter
        A criterion is named twice, or none, or the weak are stronger than the strong.
    """

    priorities: tuple[Criterion, ...] = CRITERIA
    time_critical: tuple[str, ...] = ()
    weak_power: Positive = 4.0
    strong_power: Positive = 16.0
    usable_power: Annotated[float, Meta(gt=0.0, le=1.0)] = 0.7
    usable_bandwidth: Annotated[float, Meta(gt=0.0, le=1.0)] = 0.5
    slow_rtt: Positive = 0.2
    patience: Annotated[float, Meta(ge=1.0, le=60.0)] = 3.0
    retry_after: Annotated[float, Meta(ge=0.0, le=86_400.0)] = 30.0

    def __post_init__(self) -> None:
        if not self.priorities or len(set(self.priorities)) < len(self.priorities):
            raise InvalidParameter(f"priorities of {NAME} name one or more of {', '.join(CRITERIA)}, each once")
        if self.weak_power >= self.strong_power:
            raise InvalidParameter(f"weak_power of {NAME} must be less than strong_power")


def monitor_parameters(table: dict[str, Any]) -> NodeMonitorParameters:
    """Return the parameters that a table gives.

    Raises
    ------
    InvalidParameter
        One is unknown, or cannot be.
    """
    return read_parameters(NodeMonitorParameters, NAME, table)


def with_priorities(parameters: dict[str, Any], priorities: tuple[str, ...]) -> dict[str, Any]:
    """Return the parameters of a clone by node, with the cloud's priorities where the robot's file names none."""
    own = parameters.get(NAME, {})
    if not priorities or not isinstance(own, dict):  # what is no table of parameters is told by the clone
        return parameters
    return {**parameters, NAME: {"priorities": list(priorities), **own}}
