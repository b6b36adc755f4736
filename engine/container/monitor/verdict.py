"""Verdict of the node monitor: the home of a node, with reasons.

Follows the paper's section on the node monitor: the robot's computation power, the properties of the node and the
bandwidth of the network are weighted by a list of priorities.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

from engine.container.monitor.facts import Home, MonitoredNode, NetworkLink, RobotComputer
from engine.container.monitor.parameters import Criterion, NodeMonitorParameters
from ppaas.nodes.base import Demands


class Vote(NamedTuple):
    """Vote of a criterion: its value, from −1 (robot) to 1 (cloud), and its reason."""

    value: float
    reason: str


class CriterionInput(NamedTuple):
    """Input of a criterion; the link is None while it is not measured."""

    robot: RobotComputer
    link: NetworkLink | None
    node: MonitoredNode
    demands: Demands
    parameters: NodeMonitorParameters


def computation_power(case: CriterionInput) -> Vote:
    """Vote for the cloud if the robot is weak; each doubling of its power lowers the vote by a fixed step."""
    power, parameters = case.robot.power, case.parameters
    steps = math.log(parameters.strong_power / parameters.weak_power)
    value = _clamped(1.0 - 2.0 * math.log(power / parameters.weak_power) / steps)
    if value >= 1.0:
        return Vote(value, f"the robot is weak: it has the power of {power:.1f} cores of a Raspberry Pi 4")
    return Vote(value, f"the robot has the power of {power:.1f} cores of a Raspberry Pi 4")


def node_properties(case: CriterionInput) -> Vote:
    """Vote for the robot if the node is time-critical; else by its computing demand and measured response times."""
    node, demands = case.node, case.demands
    if is_time_critical(case):
        return Vote(-1.0, f"{node.name} is time-critical")
    share = demands.compute / (case.robot.power * case.parameters.usable_power)
    demand = Vote(_clamped(2.0 * share - 1.0), f"{node.name} would use {share:.0%} of the robot's power for nodes")
    if case.link is None or node.cloud_seconds is None or node.robot_seconds is None:
        return demand
    cloud, robot = node.cloud_seconds + case.link.rtt, node.robot_seconds
    times = (robot - cloud) / max(robot, cloud)
    measured = f"it takes {robot * 1e3:.0f} ms on the robot, and {cloud * 1e3:.0f} ms in the cloud with the round trip"
    return Vote((times + demand.value) / 2.0, f"{measured}; {demand.reason}")


def network_bandwidth(case: CriterionInput) -> Vote:
    """Vote for the robot if the link is slow, or the robot's topics that the node subscribes to would fill it."""
    link, parameters = case.link, case.parameters
    if link is None:
        return Vote(0.0, "the link was not measured")
    pulled = sum(case.node.rates.values())
    share = pulled / link.bandwidth
    load = f"its topics would use {pulled / 1e3:.0f} KB/s of a link with {link.bandwidth / 1e3:.0f} KB/s"
    crowded = Vote(1.0 - 2.0 * min(share / parameters.usable_bandwidth, 1.0), load)
    slow = Vote(
        1.0 - 2.0 * min(link.rtt / parameters.slow_rtt, 1.0),
        f"a round trip over the link takes {link.rtt * 1e3:.0f} ms",
    )
    return min(crowded, slow, key=lambda vote: vote.value)


def is_time_critical(case: CriterionInput) -> bool:
    """Return whether a late answer of the node is as bad as none."""
    return case.demands.time_critical or case.node.name in case.parameters.time_critical


def _clamped(value: float) -> float:
    return min(max(value, -1.0), 1.0)


VOTES: dict[Criterion, Callable[[CriterionInput], Vote]] = {
    "computation_power": computation_power,
    "node_properties": node_properties,
    "network_bandwidth": network_bandwidth,
}


class HomeVerdict(NamedTuple):
    """Verdict on the home of a node.

    Attributes
    ----------
    home : {"cloud", "robot"}
        Home in which the node should run.
    score : float
        Weighted mean of the votes, from −1 (robot) to 1 (cloud); from 0 on, the home is the cloud.
    reasons : tuple of str
        Reasons, the most important first.
    """

    home: Home
    score: float
    reasons: tuple[str, ...]


def judge(
    robot: RobotComputer | None, link: NetworkLink | None, node: MonitoredNode, parameters: NodeMonitorParameters
) -> HomeVerdict:
    """Return the verdict on the home of a node.

    Each criterion has twice the weight of the next in the list of priorities: a clear vote of the first criterion
    decides, and otherwise the others do.

    Parameters
    ----------
    robot : RobotComputer, optional
        The robot's computer; None if the robot runs no nodes.
    link : NetworkLink, optional
        The link; None while it is not measured.
    node : MonitoredNode
        Facts about the node.
    parameters : NodeMonitorParameters
        Parameters of the node monitor.
    """
    demands = node.demands
    if robot is None:
        return _must("the robot has not reported a computer to run nodes on")
    if demands is None or node.name not in robot.nodes:
        return _must(f"{node.name} {'stays in the cloud' if demands is None else 'cannot be run by this robot'}")
    if node.failure:
        return _must(f"it could not be run on the robot: {node.failure}")
    free = max(robot.power * parameters.usable_power - node.taken, 0.0)
    if demands.compute > free:
        return _must(
            f"{node.name} takes {demands.compute:.2f} cores of a Raspberry Pi 4, and the robot has {free:.2f} left"
        )
    return _weighed(CriterionInput(robot, link, node, demands, parameters))


def asked(home: Home) -> HomeVerdict:
    """Return the verdict if a client requests a home explicitly."""
    return HomeVerdict(home, 1.0 if home == "cloud" else -1.0, ("a client requested this home",))


def _must(reason: str) -> HomeVerdict:
    return HomeVerdict("cloud", 1.0, (reason,))


def _weighed(case: CriterionInput) -> HomeVerdict:
    priorities = case.parameters.priorities
    votes = [VOTES[criterion](case) for criterion in priorities]
    weights = [2.0**-rank for rank in range(len(votes))]
    score = sum(weight * vote.value for weight, vote in zip(weights, votes, strict=True)) / sum(weights)
    reasons = (f"{name}: {vote.reason} ({vote.value:+.2f})" for name, vote in zip(priorities, votes, strict=True))
    return HomeVerdict("cloud" if score >= 0.0 else "robot", score, tuple(reasons))
