"""AGV: takes orders and instant actions, drives from node to node, and reports its state.

Inputs are methods; each may make commands, which `take_commands` returns, and a change of the state, which
`take_change` returns. There is no clock: the caller reports the end of everything that takes time.

Source: VDA 5050 2.0, 2.1 and 3.0, chapters on orders, actions and states.

Orders and updates are accepted as in VDA 5050 3.0, "Orders and order update"; 2.x has the same.
"""

import math
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import msgspec

from ppaas.geometry import Pose2D, wrap_angle
from ppaas.wire.vda5050.agv import action_book, faults
from ppaas.wire.vda5050.agv.action_book import ActionBook, InstantBook
from ppaas.wire.vda5050.agv.commands import (
    Command,
    Drive,
    DriveResult,
    Execute,
    LimitSpeed,
    Localize,
    RobotPose,
    SendFactsheet,
    Stop,
    UseZones,
)
from ppaas.wire.vda5050.agv.faults import OrderRefused, fault, order_ids
from ppaas.wire.vda5050.agv.order_check import check_order
from ppaas.wire.vda5050.agv.zone_book import ZoneBook
from ppaas.wire.vda5050.orders import Action, Edge, InstantActions, Node, NodePosition, Order
from ppaas.wire.vda5050.states import EdgeState, Error, NodeState
from ppaas.wire.vda5050.topics import Version
from ppaas.wire.vda5050.zones import ZoneSet

# -- drive of an AGV from node to node ---------------------------------------------------------------------------------


class NodeDriver:
    """Keeps the node to which the robot was ordered to drive, and the end of that drive.

    Parameters
    ----------
    command : callable
        Takes commands for the robot.

    Attributes
    ----------
    driving : bool
        Whether the robot was ordered to drive.
    goal : Node or None
        Node to which it drives, or drove until it was stopped.
    error : Error or None
        Why the robot did not reach the node; it stands until it is ordered to try again.
    """

    def __init__(self, command: Callable[[Command], None]) -> None:
        self._command = command
        self._number, self._speed = 0, 0.0
        self.driving = False
        self.goal: Node | None = None
        self.error: Error | None = None

    def drive(self, target: Node, pose: RobotPose | None) -> None:
        """Drive to a node; its heading is the direction of the way to it if it has none."""
        position = target.node_position
        assert position is not None  # orders without positions are refused
        theta = position.theta
        if theta is None:
            theta = _heading(pose, position.x, position.y)
        self._number += 1
        self.driving, self.goal = True, target
        self._command(Drive(self._number, position.x, position.y, wrap_angle(theta)))

    def stand(self) -> None:
        """Stop the robot, if it drives."""
        if self.driving:
            self.driving = False
            self._command(Stop())

    def limit(self, speed: float) -> None:
        """Limit the speed [m/s]; 0 for no limit."""
        if speed != self._speed:
            self._speed = speed
            self._command(LimitSpeed(speed))

    def ended(self, number: int, outcome: DriveResult, reason: str, references: Mapping[str, str]) -> bool:
        """Note the end of a drive; return whether it is the current one, as those that were replaced are not."""
        if number != self._number or not self.driving:
            return False
        self.driving = False
        if outcome is DriveResult.FAILED:
            text = reason or "the node was not reached"
            self.error = fault(faults.NODE_UNREACHABLE, "CRITICAL", text, references)
        return True

    def again(self) -> None:
        """Forget the failure of the last drive."""
        self.error = None


def _heading(pose: RobotPose | None, x: float, y: float) -> float:
    if pose is None:
        return 0.0
    return math.atan2(y - pose.y, x - pose.x) if pose.distance(x, y) > 1e-6 else pose.theta


# -- order of an AGV ---------------------------------------------------------------------------------------------------

OWN_DEVIATION = 0.3
"""Distance at which a node counts as reached if it allows less or says nothing [m]."""

REMEMBERED = 100
"""Number of accepted orders and updates that are recognized if they come again."""


class OrderBook:
    """Current or last order.

    Attributes
    ----------
    order_id, update_id : str, int
        Ids of the order; empty and 0 before the first one.
    nodes, edges : list
        Nodes and edges ahead, base and horizon.
    last_node, last_sequence : str, int
        Node that was reached last, and its sequence id.
    cancelled : bool
        Whether the order was cancelled.
    """

    def __init__(self) -> None:
        self.order_id, self.update_id = "", 0
        self.nodes: list[Node] = []
        self.edges: list[Edge] = []
        self.last_node, self.last_sequence = "", 0
        self.cancelled = False
        self._decision = ("", 0)
        self._accepted: deque[int] = deque(maxlen=REMEMBERED)

    @property
    def target(self) -> Node | None:
        """Next node of the base; None if the base is done."""
        return self.nodes[0] if self.nodes and self.nodes[0].released else None

    @property
    def at_end_of_base(self) -> bool:
        """True if the next node is the last of the base, and others follow."""
        return self.target is not None and len(self.nodes) > 1 and not self.nodes[1].released

    def is_repeated(self, order: Order) -> bool:
        """Return whether the same order was accepted before: brokers and networks may repeat messages."""
        return _digest(order) in self._accepted

    def is_new(self, order: Order) -> bool:
        """Return whether an order is another one, not an update of the current one."""
        return order.order_id != self.order_id

    def begin(self, order: Order, pose: RobotPose, *, idle: bool) -> None:
        """Take a new order.

        Parameters
        ----------
        order : Order
        pose : RobotPose
            Pose of the robot.
        idle : bool
            Whether no order is executed.

        Raises
        ------
        Refusal
        """
        ids = order_ids(order.order_id, order.order_update_id)
        if not idle or self.nodes:
            raise OrderRefused(
                faults.OTHER_ORDER_ACTIVE, f"order {self.order_id!r} is active: cancel it, or wait for its end", ids
            )
        first = order.nodes[0]
        if first.node_position is None:
            if first.node_id != self.last_node:
                raise OrderRefused(
                    faults.UNSUPPORTED_PARAMETER,
                    f"the first node {first.node_id!r} has no nodePosition",
                    ids,
                    "CRITICAL",
                )
        elif not is_near(pose, first.node_position):
            away = pose.distance(first.node_position.x, first.node_position.y)
            raise OrderRefused(
                faults.START_NODE_OUT_OF_RANGE,
                f"the first node {first.node_id!r} is {away:.2f} m away: begin with the node at which the robot stands",
                {**ids, "nodeId": first.node_id},
            )
        self._take(order)
        self.last_node, self.last_sequence = first.node_id, first.sequence_id

    def update(self, order: Order) -> None:
        """Take an update of the order.

        Raises
        ------
        Refusal
        """
        ids = order_ids(order.order_id, order.order_update_id)
        if order.order_update_id == self.update_id:
            raise OrderRefused(
                faults.SAME_ORDER_UPDATE_ID, f"orderUpdateId {self.update_id} was used for another update", ids
            )
        if order.order_update_id < self.update_id:
            raise OrderRefused(
                faults.OUTDATED_ORDER_UPDATE, f"the robot has update {self.update_id} of this order already", ids
            )
        if self.cancelled:
            raise OrderRefused(
                faults.ORDER_UPDATE_FOLLOWING_CANCEL, "the order was cancelled: send another orderId", ids
            )
        first = order.nodes[0]
        if (first.node_id, first.sequence_id) != self._decision:
            node, sequence = self._decision
            raise OrderRefused(
                faults.VALIDATION_FAILURE,
                f"an update begins at the end of the base, node {node!r} with sequenceId {sequence}, "
                f"not at {first.node_id!r} with {first.sequence_id}",
                {**ids, "nodeId": first.node_id},
            )
        self.nodes = [node for node in self.nodes if node.released]
        self.edges = [edge for edge in self.edges if edge.released]
        self._take(order)

    def _take(self, order: Order) -> None:
        self.nodes += order.nodes[1:]
        self.edges += order.edges
        self.order_id, self.update_id, self.cancelled = order.order_id, order.order_update_id, False
        end = [node for node in order.nodes if node.released][-1]
        self._decision = end.node_id, end.sequence_id
        self._accepted.append(_digest(order))

    def reach(self) -> Node:
        """Reach the next node, and return it."""
        node = self.nodes.pop(0)
        self.edges.pop(0)
        self.last_node, self.last_sequence = node.node_id, node.sequence_id
        return node

    def cancel(self) -> None:
        """Forget the nodes and edges ahead."""
        self.nodes, self.edges, self.cancelled = [], [], True

    def node_states(self) -> list[NodeState]:
        """Return the nodes ahead as the state has them."""
        return [
            NodeState(
                node_id=node.node_id,
                sequence_id=node.sequence_id,
                released=node.released,
                node_descriptor=node.node_descriptor,
                node_position=_position(node.node_position),
            )
            for node in self.nodes
        ]

    def edge_states(self) -> list[EdgeState]:
        """Return the edges ahead as the state has them."""
        return [
            EdgeState(
                edge_id=edge.edge_id,
                sequence_id=edge.sequence_id,
                released=edge.released,
                edge_descriptor=edge.edge_descriptor,
            )
            for edge in self.edges
        ]


def is_near(pose: RobotPose, position: NodePosition) -> bool:
    """Return whether a robot is within the deviation that a node allows, at least `OWN_DEVIATION`."""
    if pose.distance(position.x, position.y) <= OWN_DEVIATION:
        return True
    allowed = position.allowed_deviation_xy
    if allowed is None or allowed.a <= 0 or allowed.b <= 0:
        return False
    ellipse = Pose2D(0.0, 0.0, allowed.theta)
    along, across, _ = ellipse.inverse() @ Pose2D(pose.x - position.x, pose.y - position.y)
    return (along / allowed.a) ** 2 + (across / allowed.b) ** 2 <= 1.0


def _position(position: NodePosition | None) -> NodePosition | None:
    """Return a position without deviations, as states have it."""
    if position is None:
        return None
    return NodePosition(x=position.x, y=position.y, map_id=position.map_id, theta=position.theta)


def _digest(order: Order) -> int:
    return hash(msgspec.json.encode(order))


# -- the AGV: takes orders and instant actions, commands its robot, and reports its state ------------------------------

MAX_ERRORS = 10
"""Number of refusals of orders, and of instant actions, that are reported; older ones are forgotten."""


@dataclass(frozen=True, slots=True)
class Abilities:
    """Map of a robot, types of actions that it offers at nodes, on edges and at once, and types of zones."""

    map_id: str
    actions: frozenset[str] = frozenset()
    zones: tuple[str, ...] = ()


class Agv:
    """AGV that a robot is presented as.

    Parameters
    ----------
    version : Version
    abilities : Abilities

    Attributes
    ----------
    orders, actions, instants, zones : OrderBook, ActionBook, InstantBook, ZoneBook
        Orders, actions and zones that the AGV was given.
    pose : RobotPose or None
        Pose of the robot; None if it is not localized.
    why_lost : str
        Why the robot is not localized; empty if that is not known.
    paused, connected : bool
        Whether the AGV was paused, and whether its robot is connected to the cloud.
    moving : bool
        Whether the robot moves, as it may also by other clients.
    """

    def __init__(self, version: Version, abilities: Abilities) -> None:
        self._abilities = abilities
        self._strict = version.major >= 3
        self._instant_types = action_book.INSTANT_3 if version.major >= 3 else action_book.INSTANT_2
        self.orders, self.actions, self.instants = OrderBook(), ActionBook(), InstantBook()
        self.zones = ZoneBook(abilities.map_id, abilities.zones)
        self.why_lost = ""
        self.pose: RobotPose | None = None
        self.paused, self.connected, self.moving = False, False, False
        self._entered = 0
        self._order_errors: deque[Error] = deque(maxlen=MAX_ERRORS)
        self._instant_errors: deque[Error] = deque(maxlen=MAX_ERRORS)
        self._cancelling: list[Action] = []
        self._executing: dict[str, Action] = {}
        self._enabling: Action | None = None
        self._commands: list[Command] = []
        self._driver = NodeDriver(self._commands.append)
        self._changed = True
        self._instant: dict[str, Callable[[Action], None]] = {
            action_book.START_PAUSE: self._start_pause,
            action_book.STOP_PAUSE: self._stop_pause,
            action_book.CANCEL_ORDER: self._cancel_order,
            action_book.STATE_REQUEST: self._request_state,
            action_book.FACTSHEET_REQUEST: self._request_factsheet,
            action_book.INIT_POSITION: self._initialize_position,
            action_book.INITIALIZE_POSITION: self._initialize_position,
            action_book.CLEAR_INSTANT_ACTIONS: self._clear_instant_actions,
            action_book.ENABLE_ZONE_SET: self._enable_zone_set,
            action_book.DELETE_ZONE_SET: self._delete_zone_set,
        }

    # -- outputs -------------------------------------------------------------------------------------------------------

    def take_commands(self) -> list[Command]:
        """Return the commands since the last call."""
        commands = list(self._commands)
        self._commands.clear()
        return commands

    def take_change(self) -> bool:
        """Return whether the state has changed since the last call, so that it must be published."""
        changed, self._changed = self._changed, False
        return changed

    @property
    def driving(self) -> bool:
        """True if the robot was ordered to drive."""
        return self._driver.driving

    @property
    def idle(self) -> bool:
        """True if the order is done: nothing is ahead, and no action of it runs or waits."""
        return not self.orders.nodes and not self.actions.busy

    @property
    def errors(self) -> list[Error]:
        """Errors to report."""
        drive = [] if self._driver.error is None else [self._driver.error]
        errors = [*self._order_errors, *self._instant_errors, *drive]
        if not self.connected:
            text = "the robot is not connected to the cloud"
            errors.append(fault(faults.MOBILE_ROBOT_NOT_AVAILABLE, "WARNING", text, {}))
        elif self.pose is None:
            text = f"the robot is not localized{': ' if self.why_lost else ''}{self.why_lost}"
            errors.append(fault(faults.LOCALIZATION_ERROR, "FATAL", text, {}))
        return errors

    # -- orders --------------------------------------------------------------------------------------------------------

    def take_order(self, order: Order) -> None:
        """Take an order or an update, ignore one that was taken before, or report why it is refused."""
        if self.orders.is_repeated(order):
            return
        try:
            self._accept(order)
        except OrderRefused as refusal:
            self._order_errors.append(refusal.error)
        else:
            self._order_errors.clear()
            self._driver.again()
            self._advance()
        self._changed = True

    def refuse_message(self, text: str) -> None:
        """Report a message that cannot be read."""
        self._order_errors.append(fault(faults.VALIDATION_FAILURE, "WARNING", text, {}))
        self._changed = True

    def _accept(self, order: Order) -> None:
        check_order(order, self._abilities.actions, self._abilities.map_id)
        if not self.orders.is_new(order):
            self.orders.update(order)
            self.actions.keep_only([*self.orders.nodes, *self.orders.edges])
            self.actions.extend([*order.nodes, *order.edges])
            return
        ids = order_ids(order.order_id, order.order_update_id)
        if not self.connected or self.pose is None:
            text = f"the robot is not connected, or not localized{': ' if self.why_lost else ''}{self.why_lost}"
            raise OrderRefused(faults.MOBILE_ROBOT_NOT_AVAILABLE, text, ids)
        if order.order_update_id and self._strict:
            raise OrderRefused(faults.VALIDATION_FAILURE, "the orderUpdateId of a new order is 0", ids)
        self.orders.begin(order, self.pose, idle=self.idle and not self._cancelling)
        self._entered = 0
        self.actions.begin([*order.nodes, *order.edges])
        self.actions.trigger(order.nodes[0].actions)

    # -- the robot -----------------------------------------------------------------------------------------------------

    def robot_at(self, pose: RobotPose | None) -> None:
        """Note the robot's pose in the map; None if it is not localized."""
        if (pose is None) != (self.pose is None):
            self._changed = True
        self.pose = pose
        target = self.orders.target
        if pose is None or not self._driver.driving or target is None or not self._passes(target):
            return
        if target.node_position is not None and is_near(pose, target.node_position):
            self._reach()

    def robot_moves(self, *, moving: bool) -> None:
        """Note whether the robot moves."""
        if moving != self.moving:
            self.moving, self._changed = moving, True

    def drive_ended(self, number: int, outcome: DriveResult, reason: str = "") -> None:
        """Note the end of a drive; those that were replaced are ignored."""
        target = self.orders.target
        node = {"nodeId": target.node_id} if target is not None else {}
        if not self._driver.ended(number, outcome, reason, {**self._order_ids(), **node}):
            return
        self._changed = True
        if outcome is DriveResult.REACHED:
            self.moving = False
            self._reach()

    def action_ended(self, action_id: str, *, ok: bool, result: str = "") -> None:
        """Note the end of an action that the robot executed."""
        action = self._executing.pop(action_id, None)
        if action is not None:
            self.instants.set(action, "FINISHED" if ok else "FAILED", result)
        elif self.actions.end(action_id, ok=ok, result=result):
            self._finish_cancel()
            self._advance()
        self._changed = True

    def zones_used(self, zone_set_id: str, reason: str = "") -> None:
        """Note that a set of zones is in use, or why it is not."""
        action, self._enabling = self._enabling, None
        if not reason:
            self.zones.enabled = zone_set_id
        if action is not None:
            self.instants.set(action, "FAILED" if reason else "FINISHED", reason)
        self._changed = True

    def link(self, *, connected: bool) -> None:
        """Note whether the robot is connected to the cloud; a drive that was lost begins again."""
        if connected != self.connected:
            self._changed = True
        self.connected = connected
        if connected:
            self._advance()

    # -- driving -------------------------------------------------------------------------------------------------------

    def _passes(self, node: Node) -> bool:
        """Return whether the robot drives on at a node, without a stop for actions or the end of the base."""
        after = self.orders.nodes[1:2]
        return bool(after and after[0].released and not node.actions)

    def _reach(self) -> None:
        node = self.orders.reach()
        self._changed = True
        self.actions.trigger(node.actions)
        self._advance()

    def _advance(self) -> None:
        """Start the actions that may run, and drive if nothing forbids it."""
        self._start_actions()
        target = self.orders.target
        if target is None:
            self._driver.stand()
            self._driver.limit(0.0)
            return
        edge = self.orders.edges[0]
        if self._may_drive and self._entered != edge.sequence_id:
            self._entered = edge.sequence_id
            self._driver.limit(edge.maximum_speed or 0.0)
            self.actions.trigger(edge.actions)
            self._start_actions()
        if not self._may_drive:
            self._driver.stand()
        elif not self._driver.driving or self._driver.goal != target:
            self._driver.drive(target, self.pose)

    @property
    def _may_drive(self) -> bool:
        ready = self.connected and not self.paused and self._driver.error is None
        return ready and self.actions.may_drive

    def _start_actions(self) -> None:
        for action in self.actions.start():
            self._commands.append(Execute(action))

    def _order_ids(self) -> dict[str, str]:
        return order_ids(self.orders.order_id, self.orders.update_id)

    # -- instant actions -----------------------------------------------------------------------------------------------

    def take_instant_actions(self, message: InstantActions) -> None:
        """Execute instant actions; those that were received before are ignored."""
        for action in message.actions:
            if not self.instants.knows(action.action_id):
                self._execute_instant(action)
        self._changed = True

    def _execute_instant(self, action: Action) -> None:
        try:
            if action.action_type in self._instant_types:
                self.instants.set(action, "RUNNING")
                self._instant[action.action_type](action)
            elif action.action_type in self._abilities.actions:
                self._check_connected(action)
                self.instants.set(action, "RUNNING")
                self._executing[action.action_id] = action
                self._commands.append(Execute(action))
            else:
                known = "the factsheet lists those that it has"
                raise _invalid(action, f"the robot has no instant action {action.action_type!r}; {known}")
        except OrderRefused as refusal:
            self.instants.set(action, "FAILED", str(refusal))
            self._instant_errors.append(refusal.error)
        else:
            self._instant_errors.clear()

    def _check_connected(self, action: Action) -> None:
        if not self.connected:
            raise _invalid(action, "the robot is not connected to the cloud: try again")

    def _start_pause(self, action: Action) -> None:
        self.paused = True
        self._advance()
        self.instants.set(action, "FINISHED")

    def _stop_pause(self, action: Action) -> None:
        self.paused = False
        self._driver.again()
        self._advance()
        self.instants.set(action, "FINISHED")

    def _cancel_order(self, action: Action) -> None:
        wanted = action.parameter("orderId")
        if self.idle or wanted not in (None, self.orders.order_id):
            raise OrderRefused(
                faults.NO_ORDER_TO_CANCEL,
                "no order is active" if self.idle else f"order {self.orders.order_id!r} is active, not {wanted!r}",
                {"actionId": action.action_id},
            )
        self.orders.cancel()
        self.actions.cancel()
        self._driver.again()
        self._advance()
        self._cancelling.append(action)
        self._finish_cancel()

    def _finish_cancel(self) -> None:
        """End cancelOrder once no action runs any more."""
        if not self.actions.running:
            for action in self._cancelling:
                self.instants.set(action, "FINISHED")
            self._cancelling.clear()

    def _request_state(self, action: Action) -> None:
        self.instants.set(action, "FINISHED")

    def _request_factsheet(self, action: Action) -> None:
        self._commands.append(SendFactsheet())
        self.instants.set(action, "FINISHED")

    def _initialize_position(self, action: Action) -> None:
        values = [action.parameter(key) for key in ("x", "y", "theta")]
        x, y, theta = (float(v) if isinstance(v, int | float) and not isinstance(v, bool) else math.nan for v in values)
        if not all(map(math.isfinite, (x, y, theta))):
            raise _invalid(action, "x, y and theta are numbers [m, m, rad]")
        if action.parameter("mapId") != self._abilities.map_id:
            raise _invalid(action, f"the robot is on map {self._abilities.map_id!r}: mapId names no other")
        if not self.idle:
            raise _invalid(action, f"order {self.orders.order_id!r} is active: cancel it before")
        last = action.parameter("lastNodeId")
        if isinstance(last, str):
            self.orders.last_node, self.orders.last_sequence = last, 0
        self._check_connected(action)
        self._commands.append(Localize(x, y, wrap_angle(theta)))
        self.instants.set(action, "FINISHED")

    def _clear_instant_actions(self, action: Action) -> None:
        self.instants.clear_ended()
        self.instants.set(action, "FINISHED")

    # -- zones ---------------------------------------------------------------------------------------------------------

    def take_zone_set(self, message: ZoneSet) -> None:
        """Keep a set of zones, or report why it is refused."""
        try:
            self.zones.add(message.zone_set)
        except OrderRefused as refusal:
            self._instant_errors.append(refusal.error)
        self._changed = True

    def _enable_zone_set(self, action: Action) -> None:
        zone_set_id = str(action.parameter("zoneSetId"))
        self.zones.get(zone_set_id)
        if self._enabling is not None:
            raise _invalid(action, "another zone set is being enabled: try again")
        self._enabling = action
        self._commands.append(UseZones(zone_set_id))

    def _delete_zone_set(self, action: Action) -> None:
        self.zones.remove(str(action.parameter("zoneSetId")))
        self.instants.set(action, "FINISHED")


def _invalid(action: Action, text: str) -> OrderRefused:
    return OrderRefused(faults.INVALID_INSTANT_ACTION, text, {"actionId": action.action_id})
