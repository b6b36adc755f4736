"""A master control and the AGV that it leads, without I/O, for tests."""

from ppaas.geometry import Pose2D
from ppaas.wire.vda5050.master.instructions import (
    Complaint,
    Instruction,
    PathEnded,
    Progress,
    SendActions,
    SendOrder,
)
from ppaas.wire.vda5050.master.master_control import AgvPath, MasterControl
from ppaas.wire.vda5050.master.route import route_of
from ppaas.wire.vda5050.master.settings import Settings
from ppaas.wire.vda5050.states import State
from tests.support.vda5050.simple_agv import SimpleAgv


def path(name: str, *places: tuple[float, float], theta: float = 0.0) -> AgvPath:
    """Return a path through places."""
    return AgvPath(name, route_of([Pose2D(x, y, theta) for x, y in places]))


class LedAgv:
    """Master control with its AGV, whose messages arrive at once unless they are lost.

    Attributes
    ----------
    ends : list of PathEnded
    complaints : list of str
    progress : Progress or None
        The last one.
    lost : bool
        Whether messages to the AGV are lost.
    """

    def __init__(self, agv: SimpleAgv | None = None, **settings: float) -> None:
        self.settings = Settings(**settings)  # type: ignore[arg-type]
        self.agv = agv or SimpleAgv()
        self.now = 1000.0
        self.lost = False
        self.ends: list[PathEnded] = []
        self.complaints: list[str] = []
        self.progress: Progress | None = None
        self.restart()

    def restart(self) -> None:
        """Replace the master control, as a bridge that was killed."""
        self.control = MasterControl(self.settings)
        self.control.ask_again(self.now)
        self.do(self.control.take_connection("ONLINE", self.now))
        self.tell()

    def do(self, instructions: list[Instruction]) -> None:
        """Execute instructions."""
        for each in instructions:
            match each:
                case SendOrder() if not self.lost:
                    self.agv.take_order(each.order)
                case SendActions() if not self.lost:
                    self.agv.take_actions(each.actions)
                case PathEnded():
                    self.ends.append(each)
                case Complaint():
                    self.complaints.append(each.text)
                case Progress():
                    self.progress = each

    def tell(self, state: State | None = None) -> None:
        """Let the AGV publish its state, or another one."""
        self.do(self.control.take_state(state or self.agv.state(), self.now))

    def follow(self, one: AgvPath) -> None:
        """Give the AGV a path."""
        self.do(self.control.follow(one, self.now))

    def run(self, seconds: float, period: float = 0.5) -> None:
        """Let time pass, in which the AGV drives and says so."""
        for _ in range(round(seconds / period)):
            self.now += period
            self.agv.drive(period)
            self.tell()
            self.do(self.control.tick(self.now))

    @property
    def end(self) -> tuple[str, str]:
        """Name of the code and reason of the only path that has ended."""
        (one,) = self.ends
        return one.code.name, one.reason
