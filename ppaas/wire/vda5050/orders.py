"""Messages of a master control: orders and instant actions."""

from typing import Any

from msgspec import field

from ppaas.wire.vda5050.fields import BlockingType, Fields, Number, Trajectory


class ActionParameter(Fields):
    """Parameter of an action."""

    key: str
    value: Any


class Action(Fields):
    """Action at a node, on an edge, or at once."""

    action_type: str
    action_id: str
    blocking_type: BlockingType
    action_descriptor: str | None = None
    action_parameters: list[ActionParameter] | None = None
    retriable: bool | None = None

    def parameter(self, key: str) -> Any:
        """Return the value of a parameter; None if there is none of that key."""
        return next((one.value for one in self.action_parameters or () if one.key == key), None)


class Deviation(Fields):
    """Ellipse by which an AGV may miss a node: half axes [m], and the angle of the first [rad]. A radius in 2.x."""

    a: float
    b: float
    theta: float


class NodePosition(Fields):
    """Pose of a node in a map [m, m, rad]; without a heading the AGV chooses one."""

    x: float
    y: float
    map_id: str
    theta: float | None = None
    allowed_deviation_xy: Deviation | None = field(default=None, name="allowedDeviationXY")
    allowed_deviation_theta: float | None = None


class Node(Fields):
    """Node of an order; its sequence id is even."""

    node_id: str
    sequence_id: Number
    released: bool
    actions: list[Action]
    node_descriptor: str | None = None
    node_position: NodePosition | None = None


class Corridor(Fields):
    """Widths by which the AGV may leave an edge [m]."""

    left_width: float
    right_width: float
    corridor_reference_point: str | None = None
    release_required: bool | None = None
    release_loss_behavior: str | None = None


class Edge(Fields):
    """Edge between two nodes; its sequence id is odd. 3.0 leaves out the ids of its nodes."""

    edge_id: str
    sequence_id: Number
    released: bool
    actions: list[Action]
    start_node_id: str | None = None
    end_node_id: str | None = None
    edge_descriptor: str | None = None
    maximum_speed: float | None = None
    maximum_mobile_robot_height: float | None = None
    minimum_load_handling_device_height: float | None = None
    orientation: float | None = None
    orientation_type: str | None = None
    direction: str | None = None
    rotation_allowed: bool | None = None
    reach_orientation_before_entering: bool | None = None
    max_rotation_speed: float | None = None
    trajectory: Trajectory | None = None
    length: float | None = None
    corridor: Corridor | None = None


class Order(Fields):
    """Order: nodes and edges in turn. Those that are released are the base, the others the horizon."""

    order_id: str
    order_update_id: Number
    nodes: list[Node]
    edges: list[Edge]
    order_description: str | None = None
    zone_set_id: str | None = None


class InstantActions(Fields):
    """Actions to be executed at once."""

    actions: list[Action]
