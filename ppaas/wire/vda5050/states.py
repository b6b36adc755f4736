"""Messages of an AGV: its state, connection and visualization."""

from typing import Literal

from ppaas.wire.vda5050.fields import (
    Fields,
    IntermediatePath,
    PlannedPath,
    Point,
    Position,
    Reference,
    Trajectory,
    Velocity,
)
from ppaas.wire.vda5050.orders import NodePosition

ActionStatus = Literal["WAITING", "INITIALIZING", "RUNNING", "PAUSED", "RETRIABLE", "FINISHED", "FAILED"]
ENDED = frozenset({"FINISHED", "FAILED"})
"""Statuses of actions that have ended."""

OperatingMode = Literal["STARTUP", "AUTOMATIC", "SEMIAUTOMATIC", "INTERVENED", "MANUAL", "SERVICE", "TEACH_IN"]
ErrorLevel = Literal["WARNING", "URGENT", "CRITICAL", "FATAL"]
ConnectionState = Literal["ONLINE", "OFFLINE", "HIBERNATING", "CONNECTION_BROKEN"]


class NodeState(Fields):
    """Node that the AGV has not yet reached."""

    node_id: str
    sequence_id: int
    released: bool
    node_descriptor: str | None = None
    node_position: NodePosition | None = None


class EdgeState(Fields):
    """Edge that the AGV has not yet left."""

    edge_id: str
    sequence_id: int
    released: bool
    edge_descriptor: str | None = None
    trajectory: Trajectory | None = None


class ActionState(Fields):
    """State of an action."""

    action_id: str
    action_status: ActionStatus
    action_type: str | None = None
    action_descriptor: str | None = None
    action_result: str | None = None


class PowerSupply(Fields):
    """Battery: charge and health [%], voltage [V], current [A], range [m]; ``batteryState`` in 2.x."""

    state_of_charge: float
    charging: bool
    battery_voltage: float | None = None
    battery_current: float | None = None
    battery_health: float | None = None
    range: float | None = None


class Translation(Fields):
    """Text in a language."""

    translation_key: str
    translation_value: str


class Error(Fields):
    """Error; 2.x knows the levels WARNING and FATAL."""

    error_type: str
    error_level: ErrorLevel
    error_references: list[Reference] | None = None
    error_description: str | None = None
    error_description_translations: list[Translation] | None = None
    error_hint: str | None = None
    error_hint_translations: list[Translation] | None = None


class Information(Fields):
    """Information for people."""

    info_type: str
    info_level: Literal["INFO", "DEBUG"]
    info_references: list[Reference] | None = None
    info_descriptor: str | None = None


class SafetyState(Fields):
    """Emergency stop, and violation of the protective field. AUTOACK is of 2.x alone."""

    active_emergency_stop: Literal["AUTOACK", "MANUAL", "REMOTE", "NONE"]
    field_violation: bool


class MapState(Fields):
    """Map that the AGV has."""

    map_id: str
    map_version: str
    map_status: Literal["ENABLED", "DISABLED"]
    map_descriptor: str | None = None


class ZoneSetState(Fields):
    """Set of zones that the AGV has, in 3.0."""

    zone_set_id: str
    map_id: str
    zone_set_status: Literal["ENABLED", "DISABLED"]


class Dimensions(Fields):
    """Dimensions of a load [m]."""

    length: float
    width: float
    height: float | None = None


class BoundingBoxReference(Point):
    """Reference point of a load in the frame of the AGV."""

    z: float
    theta: float | None = None


class Load(Fields):
    """Load on the AGV; the weight is in kg."""

    load_id: str | None = None
    load_type: str | None = None
    load_position: str | None = None
    bounding_box_reference: BoundingBoxReference | None = None
    load_dimensions: Dimensions | None = None
    weight: float | None = None


class ZoneRequest(Fields):
    """Request of the AGV to enter a zone or to plan again in it, in 3.0."""

    request_id: str
    request_type: Literal["ACCESS", "REPLANNING"]
    zone_id: str
    zone_set_id: str
    request_status: Literal["REQUESTED", "GRANTED", "REVOKED", "EXPIRED"]
    trajectory: Trajectory | None = None


class EdgeRequest(Fields):
    """Request of the AGV to use the corridor of an edge, in 3.0."""

    request_id: str
    request_type: Literal["CORRIDOR"]
    edge_id: str
    sequence_id: int
    request_status: Literal["REQUESTED", "GRANTED", "REVOKED", "EXPIRED"]


class State(Fields):
    """State of an AGV. In 2.x instant actions are among ``actionStates``; without an order its id is empty."""

    order_id: str
    order_update_id: int
    last_node_id: str
    last_node_sequence_id: int
    driving: bool
    operating_mode: OperatingMode
    node_states: list[NodeState]
    edge_states: list[EdgeState]
    action_states: list[ActionState]
    power_supply: PowerSupply
    errors: list[Error]
    safety_state: SafetyState
    instant_action_states: list[ActionState]
    zone_action_states: list[ActionState] | None = None
    maps: list[MapState] | None = None
    zone_set_id: str | None = None
    zone_sets: list[ZoneSetState] | None = None
    mobile_robot_position: Position | None = None
    velocity: Velocity | None = None
    planned_path: PlannedPath | None = None
    intermediate_path: IntermediatePath | None = None
    loads: list[Load] | None = None
    paused: bool | None = None
    new_base_request: bool | None = None
    distance_since_last_node: float | None = None
    zone_requests: list[ZoneRequest] | None = None
    edge_requests: list[EdgeRequest] | None = None
    information: list[Information] | None = None


class Connection(Fields):
    """Connection of an AGV; the broker publishes CONNECTION_BROKEN as its last will."""

    connection_state: ConnectionState


class Visualization(Fields):
    """Pose and velocity at a higher rate than the state; paths in 3.0."""

    reference_state_header_id: int | None = None
    mobile_robot_position: Position | None = None
    velocity: Velocity | None = None
    planned_path: PlannedPath | None = None
    intermediate_path: IntermediatePath | None = None
