"""How much a machine is used: one number of round trips, network, CPU and memory, as the paper weighs them."""

import msgspec

from engine.master.machine import Machine

LATE = 0.1
"""Seconds of a round trip after which a machine is as good as full: so long after a scan its command is due."""


class Weights(msgspec.Struct, frozen=True):
    """What counts how much; only their ratios matter."""

    round_trip: float = 1.0
    network: float = 1.0
    cpu: float = 1.0
    memory: float = 1.0


def utilization(machine: Machine, round_trip: float, weights: Weights) -> float:
    """Return the utilization score of a machine: from 0, idle and near, to 1.

    Its CPUs count as used that are given away, if more than were measured: what was placed a moment ago does not
    compute yet, and a machine that looks idle would be given all that comes until it is measured again.

    Parameters
    ----------
    machine : Machine
    round_trip : float
        To whom it is to serve, or else on average [s].
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
