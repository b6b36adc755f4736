"""Which nodes of a clone the robot runs, and since when it has been silent about each."""

import msgspec

from engine.container.monitor.facts import Home
from engine.container.monitor.measurements import History
from engine.container.monitor.unacknowledged import Unheard


class Lease(msgspec.Struct):
    """The robot's hold of a node.

    Parameters
    ----------
    number : int
        No other hold of the same clone has it.
    state : str
        The node's last checkpoint.
    heard : float
        When the robot said last that it runs it [s since the epoch].
    unheard : Unheard
        What came for it since, and is not in that checkpoint.
    """

    number: int
    state: str
    heard: float
    unheard: Unheard = msgspec.field(default_factory=Unheard)


class Record(msgspec.Struct):
    """What the node monitor keeps of one node.

    Parameters
    ----------
    wanted : {"cloud", "robot"}
        Where it shall run.
    score, reasons
        Of the verdict that says so.
    lease : Lease, optional
        The robot's hold; without one it runs in the cloud.
    cloud_seconds, robot_seconds : History
        What it took for each thing that it was told [s].
    failure : str
        Why it could not be run on the robot the last time.
    failed : float
        When that was [s since the epoch].
    """

    wanted: Home = "cloud"
    score: float = 1.0
    reasons: tuple[str, ...] = ("nobody has asked for it yet",)
    lease: Lease | None = None
    cloud_seconds: History = msgspec.field(default_factory=History)
    robot_seconds: History = msgspec.field(default_factory=History)
    failure: str = ""
    failed: float = 0.0

    @property
    def home(self) -> Home:
        """Where it runs."""
        return "cloud" if self.lease is None else "robot"
