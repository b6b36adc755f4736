"""Errors and conditions that an AGV reports, in words."""

from ppaas.geometry import Pose2D
from ppaas.wire.vda5050.states import Error, State

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
