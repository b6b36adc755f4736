"""Where a node shall run: the verdict of the node monitor, with its reasons.

After the paper's section on the node monitor: the robot's computation power, the properties of the node and the
bandwidth of the network are weighed by a list of priorities.
"""

from typing import NamedTuple

from engine.container.monitor.criteria import VOTES, Case
from engine.container.monitor.facts import Home, Link, NodeFacts, Robot
from engine.container.monitor.parameters import NodeMonitorParameters


class Verdict(NamedTuple):
    """Where a node shall run.

    Attributes
    ----------
    home : {"cloud", "robot"}
        There.
    score : float
        From −1, all speaks for the robot, to 1, all speaks for the cloud; the cloud has it from 0 on.
    reasons : tuple of str
        What counts most first.
    """

    home: Home
    score: float
    reasons: tuple[str, ...]


def judge(robot: Robot | None, link: Link | None, node: NodeFacts, parameters: NodeMonitorParameters) -> Verdict:
    """Return where a node shall run.

    Each criterion counts twice as much as the next on the list of priorities. So what stands first decides where it is
    sure, and the others where it is not.

    Parameters
    ----------
    robot : Robot, optional
        None if the robot runs no nodes.
    link : Link, optional
        None while it is not measured.
    node : NodeFacts
        The node.
    parameters : NodeMonitorParameters
        What to go by.
    """
    demands = node.demands
    if robot is None:
        return _must("the robot has told of nothing to run nodes on")
    if demands is None or node.name not in robot.nodes:
        return _must(f"{node.name} {'stays in the cloud' if demands is None else 'cannot be run by this robot'}")
    if node.failure:
        return _must(f"it could not be run on the robot: {node.failure}")
    free = max(robot.power * parameters.usable_power - node.taken, 0.0)
    if demands.compute > free:
        return _must(
            f"{node.name} takes {demands.compute:.2f} cores of a Raspberry Pi 4, and the robot has {free:.2f} left"
        )
    return _weighed(Case(robot, link, node, demands, parameters))


def asked(home: Home) -> Verdict:
    """Return the verdict where somebody asks for a home by its name."""
    return Verdict(home, 1.0 if home == "cloud" else -1.0, ("it was asked for there",))


def _must(reason: str) -> Verdict:
    return Verdict("cloud", 1.0, (reason,))


def _weighed(case: Case) -> Verdict:
    priorities = case.parameters.priorities
    votes = [VOTES[criterion](case) for criterion in priorities]
    weights = [2.0**-rank for rank in range(len(votes))]
    score = sum(weight * vote.value for weight, vote in zip(weights, votes, strict=True)) / sum(weights)
    told = (f"{name}: {vote.reason} ({vote.value:+.2f})" for name, vote in zip(priorities, votes, strict=True))
    return Verdict("cloud" if score >= 0.0 else "robot", score, tuple(told))
