"""AGV of another maker, without I/O: drives the released nodes of its order in straight lines. Tests make it lie."""

import math

import msgspec

from ppaas.geometry import Pose2D
from ppaas.wire.vda5050.fields import Position, Reference, Velocity
from ppaas.wire.vda5050.orders import Action, InstantActions, Node, Order
from ppaas.wire.vda5050.states import (
    ActionState,
    EdgeState,
    Error,
    NodeState,
    PowerSupply,
    SafetyState,
    State,
    ZoneSetState,
)
from ppaas.wire.vda5050.zones import Zones, ZoneSet

SAFE = SafetyState(active_emergency_stop="NONE", field_violation=False)


class SimpleAgv:
    """AGV that takes orders and instant actions, and returns its state.

    Attributes
    ----------
    pose : Pose2D
    orders : list of Order
        Orders and updates that it has taken.
    deaf : bool
        Whether it ignores orders.
    """

    def __init__(self, pose: Pose2D = Pose2D(0.0, 0.0), *, map_id: str = "hall", speed: float = 1.0) -> None:
        self.pose, self.map_id, self.speed = pose, map_id, speed
        self.orders: list[Order] = []
        self.actions: list[Action] = []
        self.deaf = False
        self.reject = ""
        self._nodes: list[Node] = []
        self._last = ("", 0)
        self._order, self._update = "", 0
        self._errors: list[Error] = []
        self._states: list[ActionState] = []
        self._moving = False
        self.paused = False
        self.zone_sets: dict[str, Zones] = {}
        self.enabled_zones = ""

    # -- messages ------------------------------------------------------------------------------------------------------

    def take_order(self, order: Order) -> None:
        """Take an order or an update of it."""
        if self.deaf:
            return
        if self.reject:
            self._errors = [_error(self.reject, order.order_id)]
            return
        if order.order_id == self._order:
            if order.order_update_id <= self._update:
                return
            first = order.nodes[0].sequence_id
            self._nodes = [node for node in self._nodes if node.sequence_id < first] + list(order.nodes)
            self._nodes = [node for node in self._nodes if node.sequence_id > self._last[1] or not self._last[0]]
        elif self._nodes:
            self._errors = [_error("orderError: busy", order.order_id)]
            return
        else:
            self._nodes, self._last, self._states = list(order.nodes), ("", 0), []
        self.orders.append(order)
        self._order, self._update, self._errors = order.order_id, order.order_update_id, []

    def take_zones(self, message: ZoneSet) -> None:
        """Keep a set of zones, unless it has one of that id."""
        if not self.deaf:
            self.zone_sets.setdefault(message.zone_set.zone_set_id, message.zone_set)

    def take_actions(self, message: InstantActions) -> None:
        """Execute instant actions."""
        for action in message.actions:
            self.actions.append(action)
            status = "FINISHED"
            if action.action_type == "cancelOrder":
                status = "FINISHED" if self._nodes else "FAILED"
                self._nodes, self._moving = [], False
            elif action.action_type in ("startPause", "stopPause"):
                self.paused = action.action_type == "startPause"
            elif action.action_type == "initPosition":
                self.pose = Pose2D(*(float(action.parameter(key)) for key in ("x", "y", "theta")))
            elif action.action_type == "enableZoneSet":
                self.enabled_zones = str(action.parameter("zoneSetId"))
            elif action.action_type == "deleteZoneSet":
                self.zone_sets.pop(str(action.parameter("zoneSetId")), None)
            self._states.append(ActionState(action_id=action.action_id, action_status=status))

    # -- driving -------------------------------------------------------------------------------------------------------

    def drive(self, seconds: float) -> None:
        """Drive for a time [s]."""
        left = 0.0 if self.paused else self.speed * seconds
        self._moving = False
        while self._nodes and self._nodes[0].released:
            position = self._nodes[0].node_position
            assert position is not None
            apart = math.hypot(position.x - self.pose.x, position.y - self.pose.y)
            if apart > left:
                part = left / apart
                x = self.pose.x + part * (position.x - self.pose.x)
                y = self.pose.y + part * (position.y - self.pose.y)
                heading = math.atan2(position.y - self.pose.y, position.x - self.pose.x)
                self.pose, self._moving = Pose2D(x, y, heading), left > 0.0
                return
            left -= apart
            node = self._nodes.pop(0)
            theta = self.pose.theta if position.theta is None else position.theta
            self.pose, self._last = Pose2D(position.x, position.y, theta), (node.node_id, node.sequence_id)

    def state(self) -> State:
        """Return the state."""
        nodes = [
            NodeState(
                node_id=node.node_id, sequence_id=node.sequence_id, released=node.released,
                node_position=node.node_position,
            )
            for node in self._nodes
        ]  # fmt: skip
        edges = [
            EdgeState(edge_id=f"{node.node_id}e", sequence_id=node.sequence_id - 1, released=node.released)
            for node in self._nodes
            if node.sequence_id
        ]
        sets = [
            ZoneSetState(
                zone_set_id=key, map_id=zones.map_id,
                zone_set_status="ENABLED" if key == self.enabled_zones else "DISABLED",
            )
            for key, zones in self.zone_sets.items()
        ]  # fmt: skip
        return State(
            order_id=self._order, order_update_id=self._update,
            last_node_id=self._last[0], last_node_sequence_id=self._last[1],
            driving=self._moving, operating_mode="AUTOMATIC", node_states=nodes, edge_states=edges,
            action_states=[], power_supply=PowerSupply(state_of_charge=80.0, charging=False),
            errors=list(self._errors), safety_state=SAFE, instant_action_states=list(self._states[-20:]),
            mobile_robot_position=Position(
                x=self.pose.x, y=self.pose.y, theta=self.pose.theta, map_id=self.map_id, localized=True
            ),
            velocity=Velocity(vx=self.speed if self._moving else 0.0), paused=self.paused, zone_sets=sets or None,
        )  # fmt: skip

    def forget(self) -> None:
        """Drop the order, as an AGV does that was switched to manual."""
        self._nodes = []

    def lie(self, **fields: object) -> State:
        """Return the state with other fields."""
        return msgspec.structs.replace(self.state(), **fields)


def _error(text: str, order: str) -> Error:
    kind, _, description = text.partition(": ")
    reference = Reference(reference_key="orderId", reference_value=order)
    return Error(
        error_type=kind, error_level="WARNING", error_references=[reference], error_description=description or None
    )
