"""Orders along a line, for tests of AGVs."""

from ppaas.wire.vda5050.fields import BlockingType
from ppaas.wire.vda5050.orders import Action, ActionParameter, Edge, Node, NodePosition, Order

MAP = "hall"


def action(action_type: str, action_id: str, blocking: BlockingType = "NONE", **parameters: object) -> Action:
    """Return an action."""
    return Action(
        action_type=action_type,
        action_id=action_id,
        blocking_type=blocking,
        action_parameters=[ActionParameter(key=key, value=value) for key, value in parameters.items()],
    )


def node(number: int, *, released: bool = True, actions: list[Action] | None = None, map_id: str = MAP) -> Node:
    """Return node ``nN`` at x = N metres."""
    return Node(
        node_id=f"n{number}",
        sequence_id=2 * number,
        released=released,
        actions=actions or [],
        node_position=NodePosition(x=float(number), y=0.0, map_id=map_id),
    )


def edge(
    number: int, *, released: bool = True, speed: float | None = None, actions: list[Action] | None = None
) -> Edge:
    """Return the edge from node N to the next."""
    return Edge(
        edge_id=f"e{number}",
        sequence_id=2 * number + 1,
        released=released,
        actions=actions or [],
        start_node_id=f"n{number}",
        end_node_id=f"n{number + 1}",
        maximum_speed=speed,
    )


def order(first: int, base: int, horizon: int | None = None, *, update: int = 0, order_id: str = "o1") -> Order:
    """Return an order from a node to the end of its base, and to that of its horizon."""
    last = base if horizon is None else horizon
    return Order(
        order_id=order_id,
        order_update_id=update,
        nodes=[node(number, released=number <= base) for number in range(first, last + 1)],
        edges=[edge(number, released=number < base) for number in range(first, last)],
    )
