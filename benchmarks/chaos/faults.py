"""Which faults there are, and when: the same seed gives the same, as far as what they meet is the same."""

from collections.abc import Iterator
from random import Random
from typing import Literal, NamedTuple

import msgspec

How = Literal["kill", "stop", "drain"]


class FaultKind(NamedTuple):
    """A kind of fault: ``kill`` is SIGKILL, ``stop`` SIGSTOP, ``drain`` moves all that a machine carries."""

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
    FaultKind("web", "kill"), FaultKind("web", "stop"),
)  # fmt: skip
"""What can be done to a cloud; containers die more often than all else."""

OF_MORE = (FaultKind("joined machine", "kill"), FaultKind("joined machine", "stop"), FaultKind("machine", "drain"))
"""What can be done beside that where it has machines of other hosts."""

PAUSE = {"web": 3.0, "joined machine": 8.0}
"""Seconds after which what was stopped goes on, where nobody of the cloud can end it: no machine that it has lost."""

LONGEST_STOP = 25.0
"""Seconds after which all else that was stopped, and is still there, goes on."""


class InjectedFault(msgspec.Struct):
    """One that was done.

    Parameters
    ----------
    name : str
        Its kind, in words.
    at : float
        Monotonic seconds.
    home : str
        Whose process it was: the folder of the cloud or the name of a machine.
    pid : int
        Of the process; 0 where it was none.
    until : float
        When a process that was stopped had gone on or had ended; infinite until then, 0 where nothing was stopped.
    """

    name: str
    at: float
    home: str = ""
    pid: int = 0
    until: float = 0.0


def deck(random: Random, machines: int) -> Iterator[FaultKind]:
    """Yield kinds without end, each as often as the others, in an order that nobody knows."""
    kinds = [*OF_ONE_MACHINE, *(OF_MORE if machines > 1 else ())]
    while True:
        random.shuffle(kinds)
        yield from kinds
