"""Checks of an order on its own, before it is compared with what the AGV does."""

import math
from collections.abc import Container, Mapping
from itertools import pairwise

from ppaas.wire.vda5050.agv import faults
from ppaas.wire.vda5050.agv.faults import OrderRefused, order_ids
from ppaas.wire.vda5050.orders import Action, Edge, Node, Order

MAX_NODES = 1000
"""Largest number of nodes of an order, horizon included."""

MAX_ACTIONS = 1000
"""Largest number of actions of an order."""


def check_order(order: Order, actions: Container[str], map_id: str) -> None:
    """Check the order's graph, and that the AGV can do what it demands.

    Parameters
    ----------
    order : Order
    actions : container of str
        Types of actions that the AGV executes at nodes and on edges.
    map_id : str
        Map of the AGV.

    Raises
    ------
    Refusal
    """
    ids = order_ids(order.order_id, order.order_update_id)
    _check_graph(order, ids)
    _check_actions(order, actions, ids)
    for node in order.nodes[1:]:
        if node.node_position is None:
            raise OrderRefused(
                faults.UNSUPPORTED_PARAMETER,
                f"node {node.node_id!r} has no nodePosition: send it for all nodes",
                {**ids, "nodeId": node.node_id},
                "CRITICAL",
            )
    for node in order.nodes:
        if node.node_position is not None and node.node_position.map_id != map_id:
            raise OrderRefused(
                faults.UNKNOWN_MAP_ID,
                f"node {node.node_id!r} is on map {node.node_position.map_id!r}; the robot is on {map_id!r}",
                {**ids, "nodeId": node.node_id},
            )
    for edge in order.edges:
        _check_edge(edge, ids)


def _check_graph(order: Order, ids: Mapping[str, str]) -> None:
    problem = _size_problem(order) or _sequence_problem(order)
    if problem:
        raise OrderRefused(faults.VALIDATION_FAILURE, problem, ids)
    for before, edge, after in zip(order.nodes, order.edges, order.nodes[1:], strict=False):
        if edge.start_node_id not in (None, before.node_id) or edge.end_node_id not in (None, after.node_id):
            raise OrderRefused(
                faults.VALIDATION_FAILURE,
                f"edge {edge.edge_id!r} joins {before.node_id!r} and {after.node_id!r} by its sequenceId, "
                f"but {edge.start_node_id!r} and {edge.end_node_id!r} by its ids",
                {**ids, "edgeId": edge.edge_id},
            )


def _size_problem(order: Order) -> str:
    if not order.order_id:
        return "orderId is empty"
    if not 0 < len(order.nodes) <= MAX_NODES:
        return f"an order has 1 to {MAX_NODES} nodes, not {len(order.nodes)}"
    if len(order.edges) != len(order.nodes) - 1:
        return f"{len(order.nodes)} nodes need {len(order.nodes) - 1} edges, not {len(order.edges)}"
    return ""


def _sequence_problem(order: Order) -> str:
    first = order.nodes[0]
    if not first.released:
        return "the first node is not released"
    if first.sequence_id % 2:
        return f"the sequenceId of a node is even, not {first.sequence_id}"
    steps = _in_turn(order)
    for step, after in pairwise(steps):
        if after.sequence_id != step.sequence_id + 1:
            return f"sequenceId {after.sequence_id} follows {step.sequence_id}"
        if after.released and not step.released:
            return f"sequenceId {after.sequence_id} is released, the one before is not"
    if any(edge.released and not node.released for edge, node in zip(order.edges, order.nodes[1:], strict=True)):
        return "an edge is released, its end is not"
    return ""


def _in_turn(order: Order) -> list[Node | Edge]:
    """Return nodes and edges in the sequence in which they are passed."""
    steps: list[Node | Edge] = [order.nodes[0]]
    for edge, node in zip(order.edges, order.nodes[1:], strict=True):
        steps += edge, node
    return steps


def _check_actions(order: Order, actions: Container[str], ids: Mapping[str, str]) -> None:
    wanted: list[Action] = [action for step in _in_turn(order) for action in step.actions]
    if len(wanted) > MAX_ACTIONS:
        raise OrderRefused(faults.VALIDATION_FAILURE, f"an order has at most {MAX_ACTIONS} actions", ids)
    if len({action.action_id for action in wanted}) != len(wanted):
        raise OrderRefused(faults.VALIDATION_FAILURE, "two actions have the same actionId", ids)
    for action in wanted:
        if action.action_type not in actions:
            raise OrderRefused(
                faults.INVALID_ORDER_ACTION,
                f"the robot has no action {action.action_type!r}; the factsheet lists those that it has",
                {**ids, "actionId": action.action_id},
            )


def _check_edge(edge: Edge, ids: Mapping[str, str]) -> None:
    demanded = {
        "trajectory": edge.trajectory,
        "corridor": edge.corridor,
        "orientation": edge.orientation,
        "maxRotationSpeed": edge.max_rotation_speed,
    }
    for name, value in demanded.items():
        if value is not None:
            raise OrderRefused(
                faults.UNSUPPORTED_PARAMETER,
                f"edge {edge.edge_id!r} has {name!r}: the robot plans its own path and heading between nodes",
                {**ids, "edgeId": edge.edge_id},
                "CRITICAL",
            )
    if edge.maximum_speed is not None and not (math.isfinite(edge.maximum_speed) and edge.maximum_speed > 0):
        raise OrderRefused(
            faults.VALIDATION_FAILURE,
            f"the speed of edge {edge.edge_id!r} is not above 0",
            {**ids, "edgeId": edge.edge_id},
        )
