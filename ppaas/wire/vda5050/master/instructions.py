"""Instructions of the master control, which its bridge executes in order, instant actions, and reports in words."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from ppaas.geometry import Pose2D
from ppaas.messages.nav2_motions import FollowPathError
from ppaas.wire.vda5050.orders import Action, ActionParameter, InstantActions, Order
from ppaas.wire.vda5050.states import Error, State
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


STOPPING = frozenset({"CRITICAL", "FATAL"})
"""Levels of errors with which an AGV cannot go on."""

DRIVING_MODES = frozenset({"AUTOMATIC", "SEMIAUTOMATIC"})
"""Modes in which an AGV takes orders."""

MAX_TEXT = 200
"""Largest length of a text of an AGV that is repeated [characters]."""


def in_words(error: Error) -> str:
    """Return an error with its description."""
    text = error.error_type if not error.error_description else f"{error.error_type}: {error.error_description}"
    return text[:MAX_TEXT]


def fatal_error(state: State) -> str:
    """Return the first error with which the AGV cannot go on; empty if there is none."""
    return next((in_words(error) for error in state.errors if error.error_level in STOPPING), "")


def rejection(state: State, order_id: str) -> str:
    """Return the first error that refers to an order; empty if there is none."""
    for error in state.errors:
        for reference in error.error_references or ():
            if reference.reference_key == "orderId" and reference.reference_value == order_id:
                return in_words(error)
    return ""


def errors_in_words(state: State) -> str:
    """Return all errors of the AGV, separated by semicolons, cut at `MAX_TEXT`."""
    return "; ".join(in_words(error) for error in state.errors[:10])[:MAX_TEXT]


def standing(state: State) -> str:
    """Return why the AGV does not drive although it may have an order; empty if nothing keeps it."""
    if state.operating_mode not in DRIVING_MODES:
        return f"the AGV is in mode {state.operating_mode}"
    if state.safety_state.active_emergency_stop != "NONE":
        return f"the emergency stop of the AGV is active ({state.safety_state.active_emergency_stop})"
    if state.safety_state.field_violation:
        return "something is in the protective field of the AGV"
    if state.paused:
        return "the AGV is paused"
    return "" if knows_place(state) else "the AGV does not know where it is"


def knows_place(state: State) -> bool:
    """Return whether the AGV knows where it is; a position beyond all places is none."""
    position = state.mobile_robot_position
    return position is not None and position.localized and Pose2D(position.x, position.y).is_near()


def instant_action(kind: str, now: float, parameters: Mapping[str, Any] | None = None) -> InstantActions:
    """Return a message with one action, whose id contains the time [s].

    Parameters
    ----------
    kind : str
        As ``cancelOrder``, ``startPause``, ``stopPause``, ``stateRequest`` or ``factsheetRequest``.
    now : float
    parameters : mapping, optional
    """
    given = [ActionParameter(key=key, value=value) for key, value in (parameters or {}).items()]
    action = Action(action_type=kind, action_id=f"{kind}-{now:.3f}", blocking_type="NONE")
    action.action_parameters = given or None
    return InstantActions(actions=[action])


def init_position(pose: Pose2D, map_id: str, last_node: str, now: float) -> InstantActions:
    """Return the message that gives an AGV its pose, in the map as it names it."""
    place = {"x": pose.x, "y": pose.y, "theta": pose.theta, "mapId": map_id, "lastNodeId": last_node}
    return instant_action("initPosition", now, place)
