"""Order of an AGV: which nodes and edges are ahead, and which orders and updates it takes.

Source: VDA 5050 3.0, "Orders and order update", process of accepting an order or order update; 2.x has the same.
"""

from collections import deque

import msgspec

from ppaas.geometry import Pose2D
from ppaas.wire.vda5050.agv import faults
from ppaas.wire.vda5050.agv.commands import RobotPose
from ppaas.wire.vda5050.agv.faults import Refusal, order_ids
from ppaas.wire.vda5050.orders import Edge, Node, NodePosition, Order
from ppaas.wire.vda5050.states import EdgeState, NodeState

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
            raise Refusal(
                faults.OTHER_ORDER_ACTIVE, f"order {self.order_id!r} is active: cancel it, or wait for its end", ids
            )
        first = order.nodes[0]
        if first.node_position is None:
            if first.node_id != self.last_node:
                raise Refusal(
                    faults.UNSUPPORTED_PARAMETER,
                    f"the first node {first.node_id!r} has no nodePosition",
                    ids,
                    "CRITICAL",
                )
        elif not is_near(pose, first.node_position):
            away = pose.distance(first.node_position.x, first.node_position.y)
            raise Refusal(
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
            raise Refusal(
                faults.SAME_ORDER_UPDATE_ID, f"orderUpdateId {self.update_id} was used for another update", ids
            )
        if order.order_update_id < self.update_id:
            raise Refusal(
                faults.OUTDATED_ORDER_UPDATE, f"the robot has update {self.update_id} of this order already", ids
            )
        if self.cancelled:
            raise Refusal(faults.ORDER_UPDATE_FOLLOWING_CANCEL, "the order was cancelled: send another orderId", ids)
        first = order.nodes[0]
        if (first.node_id, first.sequence_id) != self._decision:
            node, sequence = self._decision
            raise Refusal(
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
