"""State and visualization of an AGV as messages."""

from collections.abc import Sequence
from dataclasses import dataclass, field

from ppaas.wire.vda5050.agv.agv import Agv
from ppaas.wire.vda5050.fields import ControlPoint, PlannedPath, Position, Trajectory, Velocity
from ppaas.wire.vda5050.states import (
    Information,
    MapState,
    PowerSupply,
    SafetyState,
    State,
    Visualization,
)

MAX_POINTS = 200
"""Largest number of control points of a planned path; paths with more are thinned out."""

LOST_AT = 1.0
"""Standard deviation of the position at which the localization score is 0 [m]."""

Points = Sequence[tuple[float, float]]


@dataclass
class Telemetry:
    """Values that the robot reports besides its pose.

    Attributes
    ----------
    power : PowerSupply
        Battery.
    velocity : Velocity or None
        Velocity in the robot's frame.
    path : sequence of (float, float)
        Planned path in the map [m].
    map_version : str
        Version of the map; empty if it is not known.
    information : list of Information
        Information for people.
    """

    power: PowerSupply
    velocity: Velocity | None = None
    path: Points = ()
    map_version: str = ""
    information: list[Information] = field(default_factory=list)


def state_of(agv: Agv, map_id: str, telemetry: Telemetry) -> State:
    """Return the state of an AGV on a map."""
    orders = agv.orders
    maps = [MapState(map_id=map_id, map_version=telemetry.map_version, map_status="ENABLED")]
    return State(
        order_id=orders.order_id,
        order_update_id=orders.update_id,
        last_node_id=orders.last_node,
        last_node_sequence_id=orders.last_sequence,
        driving=agv.driving or agv.moving,
        paused=agv.paused,
        new_base_request=agv.driving and orders.at_end_of_base,
        operating_mode="AUTOMATIC" if agv.connected else "SERVICE",
        node_states=orders.node_states(),
        edge_states=orders.edge_states(),
        action_states=agv.actions.states(),
        instant_action_states=agv.instants.states(),
        power_supply=telemetry.power,
        errors=agv.errors,
        information=telemetry.information,
        safety_state=SafetyState(active_emergency_stop="NONE", field_violation=False),
        maps=maps if telemetry.map_version else None,
        zone_sets=agv.zones.states() or None,
        mobile_robot_position=_position(agv, map_id),
        velocity=telemetry.velocity,
        planned_path=_planned(agv, telemetry.path),
    )


def visualization_of(agv: Agv, map_id: str, telemetry: Telemetry, state_id: int) -> Visualization:
    """Return the visualization that follows the state with a header id."""
    return Visualization(
        reference_state_header_id=state_id,
        mobile_robot_position=_position(agv, map_id),
        velocity=telemetry.velocity,
        planned_path=_planned(agv, telemetry.path),
    )


def _position(agv: Agv, map_id: str) -> Position:
    pose = agv.pose
    if pose is None:
        return Position(x=0.0, y=0.0, theta=0.0, map_id=map_id, localized=False, localization_score=0.0)
    return Position(
        x=pose.x,
        y=pose.y,
        theta=pose.theta,
        map_id=map_id,
        localized=agv.connected,
        localization_score=max(0.0, 1.0 - pose.deviation / LOST_AT),
        deviation_range=pose.deviation,
    )


def _planned(agv: Agv, path: Points) -> PlannedPath | None:
    """Return a path as a NURBS of degree 1, whose control points are the path's points."""
    if not agv.driving or len(path) < 2:
        return None
    points = _thinned(path)
    last = len(points) - 1
    knots = [0.0, *(index / last for index in range(last + 1)), 1.0]
    control = [ControlPoint(x=x, y=y) for x, y in points]
    target = agv.orders.target
    return PlannedPath(
        trajectory=Trajectory(control_points=control, degree=1, knot_vector=knots),
        traversed_nodes=[target.node_id] if target is not None else None,
    )


def _thinned(path: Points) -> Points:
    if len(path) <= MAX_POINTS:
        return path
    return [path[round(index * (len(path) - 1) / (MAX_POINTS - 1))] for index in range(MAX_POINTS)]
