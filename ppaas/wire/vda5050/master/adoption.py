"""Adoption of an order that an AGV drives already, after the bridge was restarted: it is not sent twice."""

from itertools import pairwise

from ppaas.wire.vda5050.master.identifiers import index_of, is_ours, key_of
from ppaas.wire.vda5050.master.order_plan import OrderPlan, PlannedNode, route_nodes
from ppaas.wire.vda5050.master.route import Route
from ppaas.wire.vda5050.states import NodeState, State


def is_active(state: State) -> bool:
    """Return whether an AGV has an order that it has not finished."""
    return bool(state.order_id) and bool(state.node_states or state.edge_states)


def is_of_this_bridge(state: State) -> bool:
    """Return whether the order of an AGV looks like one of this bridge."""
    return is_ours(state.order_id, [node.node_id for node in state.node_states])


def adopted(path: str, route: Route, map_id: str, state: State) -> OrderPlan | None:
    """Return the order of an AGV that leads along a path; None if its order leads elsewhere.

    Parameters
    ----------
    path : str
        Id of the path.
    route : Route
        Route of that path, the same as before the restart.
    map_id : str
        Map, as the AGV names it.
    state : State
        Newest state of the AGV.
    """
    key = key_of(path)
    told = [(node.node_id, node.sequence_id) for node in state.node_states]
    last = state.last_node_id, state.last_node_sequence_id
    known = [(index, sequence) for name, sequence in (*told, last) if (index := index_of(key, name)) is not None]
    if not state.order_id or not known:
        return None
    index, sequence = known[0]
    first = sequence - 2 * index
    if first < 0 or first % 2:
        return None
    prefix = [_planned(node) for node in state.node_states if node.sequence_id <= first]
    nodes = prefix + route_nodes(key, route, first)[1:] if prefix else route_nodes(key, route, first)
    plan = OrderPlan(state.order_id, path, route, map_id, nodes, before=last)
    if not _agrees(plan, told):
        return None
    _take_state(plan, state)
    return plan


def _take_state(plan: OrderPlan, state: State) -> None:
    last = plan.node(state.last_node_sequence_id)
    plan.reached = last.sequence if last is not None and last.id == state.last_node_id else None
    released = [node.sequence_id for node in state.node_states if node.released]
    plan.released = max(released, default=state.last_node_sequence_id)
    plan.update_id, plan.is_sent, plan.accepted = state.order_update_id, True, True


def _planned(node: NodeState) -> PlannedNode:
    position = node.node_position
    return PlannedNode(node.node_id, node.sequence_id, None if position is None else (position.x, position.y))


def _agrees(plan: OrderPlan, told: list[tuple[str, int]]) -> bool:
    """Return whether the sequence ids have no gap, and all nodes that the AGV names are in the order."""
    if any(b.sequence - a.sequence != 2 for a, b in pairwise(plan.nodes)):
        return False
    return all((node := plan.node(sequence)) is not None and node.id == name for name, sequence in told)
