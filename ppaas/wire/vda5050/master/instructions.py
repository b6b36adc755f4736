"""Instructions of the master control, which its bridge executes one after the other."""

from dataclasses import dataclass

from ppaas.messages.nav2_motions import FollowPathError
from ppaas.wire.vda5050.orders import InstantActions, Order
from ppaas.wire.vda5050.zones import ZoneSet


@dataclass(frozen=True, slots=True)
class SendOrder:
    """Send an order, or an update of one, to the AGV."""

    order: Order


@dataclass(frozen=True, slots=True)
class SendActions:
    """Send instant actions to the AGV."""

    actions: InstantActions


@dataclass(frozen=True, slots=True)
class SendZones:
    """Send a set of zones to the AGV."""

    zones: ZoneSet


@dataclass(frozen=True, slots=True)
class Progress:
    """Progress along a path: the rest [m], the speed [m/s], and why the AGV stands; empty while it drives."""

    path: str
    distance: float
    speed: float
    text: str = ""


@dataclass(frozen=True, slots=True)
class PathEnded:
    """A path has ended: at its goal (``NONE``), or with an error and its reason."""

    path: str
    code: FollowPathError
    reason: str = ""


@dataclass(frozen=True, slots=True)
class Complaint:
    """The AGV contradicts its order, or does not follow it, in words."""

    text: str


Instruction = SendOrder | SendActions | SendZones | Progress | PathEnded | Complaint
