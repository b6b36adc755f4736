"""Kinds of faults and their random order, which depends on the seed alone."""

from collections.abc import Iterator, Sequence
from random import Random
from typing import Literal, NamedTuple

import msgspec

How = Literal["kill", "stop", "drain"]


class FaultKind(NamedTuple):
    """A kind of fault: ``kill`` sends SIGKILL, ``stop`` sends SIGSTOP, ``drain`` moves all containers off a machine."""

    victim: str
    how: How

    def __str__(self) -> str:
        return f"{self.victim}, {_IN_WORDS[self.how]}"


_IN_WORDS = {"kill": "killed", "stop": "stopped", "drain": "drained"}

OF_ONE_MACHINE = (
    FaultKind("container", "kill"), FaultKind("container", "kill"), FaultKind("container", "stop"),
    FaultKind("fork server", "kill"), FaultKind("fork server", "stop"),
    FaultKind("router", "kill"), FaultKind("router", "stop"),
    FaultKind("agent", "kill"), FaultKind("agent", "stop"),
    FaultKind("helper", "kill"),
    FaultKind("master", "kill"), FaultKind("master", "stop"),
    FaultKind("endpoint", "kill"), FaultKind("endpoint", "stop"),
)  # fmt: skip
"""Faults of a cloud with one machine; containers are killed twice as often as other processes."""

OF_MORE = (FaultKind("joined machine", "kill"), FaultKind("joined machine", "stop"), FaultKind("machine", "drain"))
"""Additional faults of a cloud with joined machines."""

OF_TWO_MASTERS = (FaultKind("standby", "kill"), FaultKind("standby", "stop"))
"""Additional faults of a cloud with a standby."""

OF_TRAFFIC = (FaultKind("traffic node", "kill"), FaultKind("traffic node", "kill"), FaultKind("traffic node", "stop"))
"""Additional faults of a cloud with robots in traffic."""

PAUSES = {"master": (3.0,), "standby": (3.0, 8.0), "joined machine": (8.0,)}
"""Times after which stopped processes continue, for processes that the cloud itself cannot kill [s]."""

REPLACED_AFTER = 8.0
"""Another such time for a master that a standby replaces meanwhile [s]. The other one is just the standby's patience,
so that the master goes on while it is replaced."""

LONGEST_STOP = 25.0
"""Time after which other stopped processes continue if the cloud has not killed them [s]."""


class CloudSize(NamedTuple):
    """Size of a cloud: the parts that may fail.

    Parameters
    ----------
    machines : int
        Number of its machines.
    standby : bool
        Whether it has a standby.
    traffic : bool
        Whether it has robots in traffic.
    """

    machines: int
    standby: bool = False
    traffic: bool = False


class InjectedFault(msgspec.Struct):
    """An injected fault.

    Parameters
    ----------
    name : str
        Kind of the fault, in words.
    at : float
        Time of the fault [monotonic s].
    home : str
        Name of the machine of the process, or of the drained machine.
    pid : int
        Process id; 0 for a drained machine.
    until : float
        Time when a stopped process continued or had exited; infinite until then, 0 if nothing was stopped.
    """

    name: str
    at: float
    home: str = ""
    pid: int = 0
    until: float = 0.0


def pauses(victim: str, *, standby: bool) -> Sequence[float]:
    """Return the times after which a stopped process may continue [s]; ``standby`` is true in a cloud with one."""
    ordinary = PAUSES.get(victim, (LONGEST_STOP,))
    return (*ordinary, REPLACED_AFTER) if standby and victim == "master" else ordinary


def deck(random: Random, cloud: CloudSize) -> Iterator[FaultKind]:
    """Yield kinds without end: all kinds in random order, then again in another order."""
    kinds = [*OF_ONE_MACHINE, *(OF_MORE if cloud.machines > 1 else ()), *(OF_TWO_MASTERS if cloud.standby else ())]
    kinds += OF_TRAFFIC if cloud.traffic else ()
    while True:
        random.shuffle(kinds)
        yield from kinds
