"""Instant actions of a master control."""

from collections.abc import Mapping
from typing import Any

from ppaas.geometry import Pose2D
from ppaas.wire.vda5050.orders import Action, ActionParameter, InstantActions


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
