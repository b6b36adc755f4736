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
    """Parameters of a node monitor: defaults of the cloud, which a robot's file may override.

    Parameters
    ----------
    priorities : tuple of str
        Criteria by weight, the largest first; a criterion that is left out has no weight.
    time_critical : tuple of str
        Nodes for which a late answer is as bad as none, besides those whose class declares it.
    weak_power, strong_power : float
        Powers at and below which a robot counts as weak, at and above which as strong [cores of a Raspberry Pi 4].
        A Raspberry Pi 4 has a power of four.
    usable_power : float
        Fraction of the robot's power that nodes may use.
    usable_bandwidth : float
        Fraction of the link's bandwidth that nodes in the cloud may use.
    slow_rtt : float
        Round-trip time from which a link is too slow to drive a robot over [s].
    patience : float
        Time without a renewal of its lease after which a node on the robot continues in the cloud [s].
    retry_after : float
        Time for which a node that failed on the robot stays in the cloud, unless a client requests the robot [s].

    Raises
    ------
    InvalidParameter
        ``priorities`` is empty or lists a criterion twice, or ``weak_power`` is not less than ``strong_power``.
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
            raise InvalidParameter(f"priorities of {NAME} must list one or more of {', '.join(CRITERIA)}, each once")
        if self.weak_power >= self.strong_power:
            raise InvalidParameter(f"weak_power of {NAME} must be less than strong_power")


def monitor_parameters(table: dict[str, Any]) -> NodeMonitorParameters:
    """Return the parameters in a table of a robot's file.

    Raises
    ------
    InvalidParameter
        A parameter is unknown, or its value is invalid.
    """
    return read_parameters(NodeMonitorParameters, NAME, table)


def with_priorities(parameters: dict[str, Any], priorities: tuple[str, ...]) -> dict[str, Any]:
    """Return the parameters of a clone by node, with the cloud's priorities if the robot's file has none."""
    own = parameters.get(NAME, {})
    if not priorities or not isinstance(own, dict):  # the clone reports parameters that are not a table
        return parameters
    return {**parameters, NAME: {"priorities": list(priorities), **own}}
