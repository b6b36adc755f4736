"""Contradictions between an order and the state that an AGV reports, in words."""

import math
from itertools import pairwise

from ppaas.wire.vda5050.fields import Position
from ppaas.wire.vda5050.master.order_plan import OrderPlan
from ppaas.wire.vda5050.master.settings import Settings
from ppaas.wire.vda5050.states import State

MARGIN = 1.5
"""Factor on the top speed up to which a distance between two nodes is believed."""

SLACK = 2.0
"""Distance that is always believed [m]: clocks and networks are not exact."""


def contradiction(plan: OrderPlan, state: State, now: float, settings: Settings) -> str:
    """Return the first contradiction of a state to the order that it names; empty if there is none.

    Parameters
    ----------
    plan : OrderPlan
        Order as it was sent.
    state : State
        State with the order's id.
    now : float
        Time of the state [s].
    settings : Settings
    """
    return _numbers(plan, state) or _nodes(plan, state) or _last_node(plan, state, now, settings)


def _numbers(plan: OrderPlan, state: State) -> str:
    if state.order_update_id <= plan.update_id:
        return ""
    return f"it names update {state.order_update_id} of its order, whose newest is {plan.update_id}"


def _nodes(plan: OrderPlan, state: State) -> str:
    for told in state.node_states:
        node = plan.node(told.sequence_id)
        if node is None or node.id != told.node_id:
            return f"it is to reach node {told.node_id[:60]!r} ({told.sequence_id}), which its order does not have"
        if told.released and node.sequence > plan.released:
            return f"it counts node {told.node_id[:60]!r} ({told.sequence_id}) as released, which it is not"
    return ""


def _last_node(plan: OrderPlan, state: State, now: float, settings: Settings) -> str:
    name, sequence = state.last_node_id, state.last_node_sequence_id
    if plan.reached is None and (not name or (name, sequence) == plan.before):
        return ""
    node, words = plan.node(sequence), f"node {name[:60]!r} ({sequence})"
    if node is None or node.id != name:
        return f"the last node that it reached is {words}, which its order does not have"
    if plan.reached is not None and sequence < plan.reached:
        return f"it went back to {words} after it had reached {plan.reached}"
    if sequence > plan.released:
        return f"it reached {words}, beyond the end of its base ({plan.released})"
    seconds = now - plan.reached_at
    far = plan.between(plan.position(plan.reached), plan.position(sequence))
    if far > MARGIN * settings.top_speed * seconds + SLACK:
        return f"it jumped {far:.1f} m along its route to {words} in {seconds:.1f} s"
    return _far_from_node(node.place, state, words, settings) if node is plan.last else ""


def _far_from_node(place: tuple[float, float] | None, state: State, words: str, settings: Settings) -> str:
    """Return a contradiction of an AGV that says to be at its last node, with no node left, and is elsewhere."""
    position = state.mobile_robot_position
    if place is None or position is None or not position.localized or state.node_states:
        return ""
    far = math.hypot(position.x - place[0], position.y - place[1])
    limit = settings.end_deviation + 0.5
    return f"it says that it reached {words}, but is {far:.2f} m away from it" if far > limit else ""


def distance_off(plan: OrderPlan, state: State) -> float:
    """Return the distance of an AGV from the edge that it drives on, by its own position [m]; 0 if that is unknown.

    Edges next to it count as well, since the node between may be reached any moment.
    """
    position = state.mobile_robot_position
    if position is None or not position.localized or position.map_id != plan.map_id:
        return 0.0
    at = plan.position(plan.reached)
    places = [node.place for node in plan.nodes[max(at - 1, 0) : at + 3] if node.place is not None]
    return min((_apart(begin, end, position) for begin, end in pairwise(places)), default=0.0)


def _apart(begin: tuple[float, float], end: tuple[float, float], position: Position) -> float:
    """Return the distance of a position from an edge [m]: for one, numpy takes five times as long."""
    along_x, along_y = end[0] - begin[0], end[1] - begin[1]
    x, y = position.x - begin[0], position.y - begin[1]
    part = min(max((x * along_x + y * along_y) / max(along_x**2 + along_y**2, 1e-12), 0.0), 1.0)
    return math.hypot(x - part * along_x, y - part * along_y)
