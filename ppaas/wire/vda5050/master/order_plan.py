"""Order as it was sent so far: its identifiers, its nodes, which of them are released, and how it grows."""

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from hashlib import blake2b
from itertools import pairwise

from ppaas.wire.vda5050.master.route import Route
from ppaas.wire.vda5050.master.settings import Settings
from ppaas.wire.vda5050.orders import Deviation, Edge, Node, NodePosition, Order

# -- identifiers of orders and nodes -----------------------------------------------------------------------------------

_KEY = re.compile(r"(?P<key>[0-9a-f]{16})(-(?P<index>\d{1,6}))?")


def key_of(path: str) -> str:
    """Return the key of a path: 16 hexadecimal digits."""
    return blake2b(path.encode(), digest_size=8).hexdigest()


def node_id(key: str, index: int) -> str:
    """Return the id of the node at a corner of the route of a path."""
    return f"{key}-{index}"


def index_of(key: str, node: str) -> int | None:
    """Return the corner of a node of a path; None for a node of another path."""
    found = _KEY.fullmatch(node)
    return int(found["index"]) if found and found["index"] and found["key"] == key else None


def is_ours(order: str, nodes: list[str]) -> bool:
    """Return whether an order and its nodes have identifiers as this module makes them."""
    return bool(_KEY.fullmatch(order)) and all(_KEY.fullmatch(node) for node in nodes)


# -- order as it was sent so far ---------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class PlannedNode:
    """Node of an order: its id, sequence id, place [m], and heading [rad] if that matters.

    The place is None for a node of which only the AGV knows more, after a restart.
    """

    id: str
    sequence: int
    place: tuple[float, float] | None
    theta: float | None = None


@dataclass(slots=True)
class OrderPlan:
    """Order of one AGV.

    Attributes
    ----------
    order_id : str
    update_id : int
        Of the newest message.
    path : str
        Id of the path that the order ends with.
    route : Route
        Route of that path.
    map_id : str
        Map of the nodes, as the AGV names it.
    nodes : list of PlannedNode
        All nodes from the first; sequence ids are even.
    released : int
        Sequence id of the last released node.
    newest : Order or None
        The newest message.
    is_sent : bool
        Whether the AGV has a message of the order.
    accepted : bool
        Whether the AGV has taken the newest message.
    reached : int or None
        Sequence id of the last node that the AGV has reached; None before the first.
    reached_at : float
        Time at which it was reached [s]; before the first, the time of the order.
    before : (str, int)
        Id and sequence id of the last node that the AGV named before this order.
    """

    order_id: str
    path: str
    route: Route
    map_id: str
    nodes: list[PlannedNode]
    update_id: int = 0
    released: int = -1
    newest: Order | None = None
    is_sent: bool = False
    accepted: bool = False
    reached: int | None = None
    reached_at: float = -math.inf
    before: tuple[str, int] = ("", 0)

    @classmethod
    def of(cls, path: str, route: Route, map_id: str, before: tuple[str, int]) -> "OrderPlan":
        """Return the order for a route; ``before`` is the last node that the AGV says to have reached."""
        key = key_of(path)
        return cls(key, path, route, map_id, route_nodes(key, route, 0), before=before)

    def node(self, sequence: int) -> PlannedNode | None:
        """Return a node by its sequence id, or None."""
        index = (sequence - self.nodes[0].sequence) // 2
        return self.nodes[index] if sequence % 2 == 0 and 0 <= index < len(self.nodes) else None

    @property
    def last(self) -> PlannedNode:
        """The last node of the route."""
        return self.nodes[-1]

    @property
    def is_finished(self) -> bool:
        """True if the AGV has reached the last node."""
        return self.reached == self.last.sequence

    def position(self, sequence: int | None) -> int:
        """Return the index of a node by its sequence id; 0 for None."""
        return 0 if sequence is None else max((sequence - self.nodes[0].sequence) // 2, 0)

    def between(self, first: int, last: int) -> float:
        """Return the length from one node to another, by their indices [m]; nodes without a place are passed over."""
        places = [node.place for node in self.nodes[first : last + 1] if node.place is not None]
        return _length(places)

    # -- messages ------------------------------------------------------------------------------------------------------

    def needs_release(self, settings: Settings) -> bool:
        """Return whether less than half of the base is left, and nodes beyond it wait."""
        if not self.accepted or self.released >= self.last.sequence:
            return False
        left = self.between(self.position(self.reached), self.position(self.released))
        return left < 0.5 * settings.base_length

    def message(self, settings: Settings) -> Order:
        """Return the first message, or an update that releases more nodes, from the last released one on."""
        first = self.position(self.released) if self.released >= 0 else 0
        last = min(first + settings.max_nodes - 1, len(self.nodes) - 1)
        nodes = self.nodes[first : last + 1]
        self.released = self.nodes[min(self._base_end(settings), last)].sequence
        self.update_id += self.is_sent
        self.is_sent, self.accepted = True, False
        self.newest = Order(
            order_id=self.order_id,
            order_update_id=self.update_id,
            nodes=[self._node_message(node, settings) for node in nodes],
            edges=[self._edge_message(a, b) for a, b in pairwise(nodes)],
        )
        return self.newest

    def lead_on(self, path: str, route: Route, beyond: Route) -> None:
        """End the order with another path: ``beyond`` the end of the base it has other nodes."""
        kept = self.nodes[: self.position(self.released) + 1]
        self.nodes = kept + route_nodes(key_of(path), beyond, kept[-1].sequence)[1:]
        self.path, self.route = path, route

    def _base_end(self, settings: Settings) -> int:
        """Return the index of the last node to release: the base has its length, but at least one edge."""
        begin = self.position(self.reached)
        least = max(begin, self.position(self.released) if self.released >= 0 else begin)
        end = min(least + 1, len(self.nodes) - 1)
        while end < len(self.nodes) - 1 and self.between(begin, end) < settings.base_length:
            end += 1
        return end

    def _node_message(self, node: PlannedNode, settings: Settings) -> Node:
        is_last = node.sequence == self.last.sequence
        radius = settings.end_deviation if is_last else settings.deviation
        position = None
        if node.place is not None:
            x, y = node.place
            radii = Deviation(a=radius, b=radius, theta=0.0)
            position = NodePosition(x=x, y=y, map_id=self.map_id, theta=node.theta, allowed_deviation_xy=radii)
        released = node.sequence <= self.released
        return Node(node_id=node.id, sequence_id=node.sequence, released=released, node_position=position, actions=[])

    def _edge_message(self, begin: PlannedNode, end: PlannedNode) -> Edge:
        return Edge(
            edge_id=f"{end.id}e",
            sequence_id=end.sequence - 1,
            released=end.sequence <= self.released,
            start_node_id=begin.id,
            end_node_id=end.id,
            actions=[],
        )


def route_nodes(key: str, route: Route, first: int) -> list[PlannedNode]:
    """Return the nodes of a route, whose first one has a sequence id; the last one has the heading of the route."""
    count = len(route.points)
    thetas = (*(None,) * (count - 1), route.theta)
    return [
        PlannedNode(node_id(key, index), first + 2 * index, (float(x), float(y)), theta)
        for index, ((x, y), theta) in enumerate(zip(route.points.tolist(), thetas, strict=True))
    ]


def _length(places: Sequence[tuple[float, float]]) -> float:
    return sum(math.dist(begin, end) for begin, end in pairwise(places))
