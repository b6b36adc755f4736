"""What the robot carries: taken up at a dock as its lift reports, until the lift is down again."""

import msgspec

from ppaas.docking.dock import MappedDock
from ppaas.docking.parameters import DockingParameters, DockType
from ppaas.docking.watch import CARRIES
from ppaas.footprints import Footprint
from ppaas.messages.geometry_msgs import Point32, Polygon
from ppaas.nodes import topics
from ppaas.nodes.base import Context


class Load(msgspec.Struct, frozen=True):
    """Load of a robot.

    Parameters
    ----------
    dock_type : str
        Type of dock at which it was taken up.
    text : str
        What it is, in words.
    """

    dock_type: str
    text: str


class CarriedLoad:
    """Keeps what the robot carries, and publishes its outline.

    Parameters
    ----------
    context : Context
        Context of the node.
    parameters : DockingParameters

    Attributes
    ----------
    load : Load or None
    """

    def __init__(self, context: Context, parameters: DockingParameters) -> None:
        self.load: Load | None = None
        self._context, self._types = context, parameters.dock_types
        self._expected: Load | None = None

    @property
    def report(self) -> str:
        """What the robot carries, in words; empty if nothing."""
        return "" if self.load is None else f"{CARRIES}{self.load.text}"

    def expect(self, dock: MappedDock, dock_type: str) -> None:
        """Note at which dock the lift was sent up, by its name and its type."""
        self._expected = Load(dock_type, f"the load of {dock.in_words}")

    def note(self, lifted: bool | None) -> bool:
        """Take what the lift reports; return whether that has changed what the robot carries.

        A lift that is up without an order carries a load of the only type that there is.
        """
        if lifted is None or lifted is (self.load is not None):
            return False
        self.load, self._expected = (self._expected or self._only()) if lifted else None, None
        if lifted and self.load is None:
            return False
        outline: Footprint = () if self.load is None else self._types.get(self.load.dock_type, DockType()).load
        self._context.publish(topics.LOCAL_LOAD.name, Polygon([Point32(x, y) for x, y in outline]))
        return True

    def _only(self) -> Load | None:
        """Return a load of the only type of loads."""
        of_loads = [name for name, kind in self._types.items() if kind.load]
        return Load(of_loads[0], f"a load of type {of_loads[0]!r}") if len(of_loads) == 1 else None
