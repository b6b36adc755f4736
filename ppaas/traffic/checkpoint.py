"""Checkpoint of the traffic: the epoch, and what each robot was known to hold."""

import msgspec

from ppaas.decoding import from_msgpack
from ppaas.errors import InvalidInput
from ppaas.messages.fleet.traffic import TrafficReport
from ppaas.traffic.coordinator import Coordinator


class TrafficCheckpoint(msgspec.Struct):
    """State of a coordinator from which the next one begins.

    Parameters
    ----------
    epoch : int
    reports : list of TrafficReport
        The newest of each robot, with all cells that it may hold or be granted soon as its way.
    goals : int
        Number of goals reached.
    out : list of str
        Robots that an operator has taken out.
    """

    epoch: int
    reports: list[TrafficReport] = []
    goals: int = 0
    out: list[str] = []


def checkpoint_of(coordinator: Coordinator) -> bytes:
    """Return the checkpoint of a coordinator."""
    occupancy = coordinator.occupancy
    out = [name for name, member in occupancy.members.items() if member.standing == "out"]
    return msgspec.msgpack.encode(TrafficCheckpoint(coordinator.epoch, occupancy.known(), occupancy.goals, out))


def restore(coordinator: Coordinator, state: bytes, now: float) -> None:
    """Start a coordinator from a checkpoint: it waits for the robots in it, and treats what they held as held.

    Those that were taken out stay out.

    Raises
    ------
    InvalidInput
        The checkpoint is not valid.
    """
    try:
        read = from_msgpack(state, TrafficCheckpoint)
    except msgspec.DecodeError as error:
        raise InvalidInput(f"the checkpoint of the traffic is not valid: {error}") from error
    coordinator.epoch, coordinator.occupancy.goals = read.epoch, read.goals
    for report in read.reports:
        coordinator.report(report, now)
    for member in coordinator.members.values():
        member.restored = True
    for name in set(read.out) & coordinator.members.keys():
        coordinator.occupancy.take_out(name)
