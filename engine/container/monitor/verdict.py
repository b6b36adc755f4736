"""Verdict of the node monitor: the home of a node, with reasons.

Follows the paper's section on the node monitor: the robot's computation power, the properties of the node and the
bandwidth of the network are weighted by a list of priorities.
"""

from typing import NamedTuple

from engine.container.monitor.criteria import VOTES, CriterionInput
from engine.container.monitor.facts import Home, Link, NodeFacts, Robot
from engine.container.monitor.parameters import NodeMonitorParameters


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


def judge(robot: Robot | None, link: Link | None, node: NodeFacts, parameters: NodeMonitorParameters) -> HomeVerdict:
    """Return the verdict on the home of a node.

    Each criterion has twice the weight of the next in the list of priorities: a clear vote of the first criterion
    decides, and otherwise the others do.

    Parameters
    ----------
    robot : Robot, optional
        The robot's computer; None if the robot runs no nodes.
    link : Link, optional
        The link; None while it is not measured.
    node : NodeFacts
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
