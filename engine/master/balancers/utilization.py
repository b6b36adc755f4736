"""Utilization score of a machine: the paper's weighted mean of round trip, network, CPU and memory."""

import msgspec

from engine.master.machine import Machine

LATE = 0.1
"""Round trip that counts as full use [s]: the time after a scan within which its command is due."""


class Weights(msgspec.Struct, frozen=True):
    """Weights of the terms of the score; only their ratios matter."""

    round_trip: float = 1.0
    network: float = 1.0
    cpu: float = 1.0
    memory: float = 1.0


def utilization(machine: Machine, round_trip: float, weights: Weights) -> float:
    """Return the utilization score of a machine: 0 if it is idle and near, up to 1.

    The CPU term is the larger of the cores given to containers and the measured load. Containers placed a moment ago do
    not load the CPU yet; by the measured load alone, a machine that looks idle would get every new container until its
    next report.

    Parameters
    ----------
    machine : Machine
    round_trip : float
        Round trip to the robot to be served, or the average round trip [s].
    weights : Weights
    """
    given = machine.given / machine.capacity if machine.capacity else 1.0
    shares = (
        (weights.round_trip, round_trip / LATE),
        (weights.network, machine.network_used / machine.network if machine.network else 0.0),
        (weights.cpu, max(given, machine.cpu / machine.cores if machine.cores else 1.0)),
        (weights.memory, machine.memory_used / machine.memory if machine.memory else 0.0),
    )
    total = sum(weight for weight, _ in shares)
    return sum(weight * min(share, 1.0) for weight, share in shares) / total if total else 0.0
