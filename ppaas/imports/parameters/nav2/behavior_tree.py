"""Behaviour trees of Nav2: the rate of planning, and the recoveries in the order in which they are tried.

A tree is read for these two alone. Source: BehaviorTree.CPP, formats 3 and 4, and the trees of nav2_bt_navigator.
"""

from collections.abc import Iterator, Mapping
from typing import Any
from xml.etree.ElementTree import Element, ParseError

import msgspec
from defusedxml.common import DefusedXmlException
from defusedxml.ElementTree import fromstring

from ppaas.errors import InvalidParameter
from ppaas.navigation.parameters import MAX_RECOVERIES

MAX_TREE = 1 << 20
"""Limit of the size of a tree [bytes]."""

MAX_NODES = 10_000
"""Limit of the nodes of a tree, with subtrees wherever they are used."""

PLANS = frozenset({"ComputePathToPose", "ComputePathThroughPoses", "ComputeRoute", "ComputeAndTrackRoute"})
CLEARS = frozenset({"ClearEntireCostmap", "ClearCostmapExceptRegion", "ClearCostmapAroundRobot"})
EXPLICIT = frozenset({"Action", "Condition", "Control", "Decorator"})
"""Elements that name the node in the attribute ID."""

_Ports = Mapping[str, tuple[str, float]]

RECOVERIES: dict[str, tuple[str, str, _Ports]] = {
    "Spin": ("spin", "rotate_recovery", {"spin_dist": ("spin_dist", 1.57)}),
    "Wait": ("wait", "wait", {"wait_duration": ("wait_duration", 1.0)}),
    "BackUp": (
        "backup",
        "back_up",
        {
            "backup_dist": ("backup_dist", 0.15),
            "backup_speed": ("backup_speed", 0.025),
            "time_allowance": ("time_allowance", 10.0),
        },
    ),
}
"""Our name, our plug-in, and our parameters by port, with Nav2's default, by the node of a tree."""

CLEAR = ("clear_costmaps", "clear_costmap_recovery")
"""Our name and plug-in of all nodes that clear costmaps."""


class RecoveryEntry(msgspec.Struct, frozen=True):
    """One entry of the list of recoveries.

    Parameters
    ----------
    name, type : str
        As in Move Base's list.
    parameters : mapping
    """

    name: str
    type: str
    parameters: dict[str, float]


class Tree(msgspec.Struct, frozen=True):
    """What a clone takes of a tree.

    Parameters
    ----------
    rate : float
        Rate of planning while the robot drives [Hz]; 0 if the tree plans once.
    recoveries : tuple of RecoveryEntry
        In order, as often as the tree retries.
    others : tuple of str
        Names of the nodes that are not taken.
    """

    rate: float
    recoveries: tuple[RecoveryEntry, ...]
    others: tuple[str, ...]


def read_tree(content: bytes) -> Tree:
    """Read a behaviour tree.

    Raises
    ------
    InvalidParameter
        The file is no XML, is too large, has a document type or entities, or no tree.
    """
    if len(content) > MAX_TREE:
        raise InvalidParameter(f"a behaviour tree may have at most {MAX_TREE} bytes, not {len(content)}")
    try:
        root = fromstring(content, forbid_dtd=True)
    except DefusedXmlException as error:
        raise InvalidParameter("a behaviour tree must not have a document type or entities: remove them") from error
    except (ParseError, ValueError, LookupError) as error:
        raise InvalidParameter(f"the behaviour tree is no XML: {error}") from error
    trees = {each.get("ID", ""): each for each in root.iter("BehaviorTree")}
    if not trees:
        raise InvalidParameter("the behaviour tree has no element <BehaviorTree>")
    main = trees.get(root.get("main_tree_to_execute", ""), next(iter(trees.values())))
    nodes = list(_walk(main, trees))
    names = [node.name for node in nodes]
    recoveries = tuple(_recoveries(nodes))
    taken = {each.type for each in recoveries}
    known = {name for name, (_, plugin, _) in RECOVERIES.items() if plugin in taken}
    known |= CLEARS if CLEAR[1] in taken else set()
    known |= {"RateController", "RecoveryNode", "RoundRobin", "BehaviorTree", *PLANS}
    others = dict.fromkeys(name for name in names if name not in known)
    return Tree(_rate(nodes), recoveries, tuple(others))


class _Node(msgspec.Struct):
    """Node of a tree in document order; ``end`` is the index after its last descendant."""

    name: str
    ports: Mapping[str, str]
    depth: int
    parent: int
    end: int = 0


def _walk(main: Element, trees: Mapping[str, Element]) -> list[_Node]:
    """Return the nodes of a tree in document order, with those of its subtrees in their places."""
    nodes: list[_Node] = []
    stack: list[tuple[Element, int, int, frozenset[str]]] = [(main, 0, -1, frozenset())]
    while stack:
        element, depth, parent, within = stack.pop()
        if len(nodes) >= MAX_NODES:
            raise InvalidParameter(f"a behaviour tree may have at most {MAX_NODES} nodes, with its subtrees")
        name = element.get("ID", "") if element.tag in EXPLICIT else str(element.tag)
        children = list(element)
        if name in ("SubTree", "SubTreePlus"):
            subtree = element.get("ID", "")
            name, children = subtree or name, [] if subtree in within else list(trees.get(subtree, ()))
            within |= {subtree}
        nodes.append(_Node(name, element.attrib, depth, parent))
        stack.extend((child, depth + 1, len(nodes) - 1, within) for child in reversed(children))
    for index in range(len(nodes) - 1, -1, -1):
        nodes[index].end = max(nodes[index].end, index + 1)
        if nodes[index].parent >= 0:
            parent_node = nodes[nodes[index].parent]
            parent_node.end = max(parent_node.end, nodes[index].end)
    return nodes


def _rate(nodes: list[_Node]) -> float:
    """Return the rate of the first controller of a rate that has a node that plans below it."""
    for index, node in enumerate(nodes):
        if node.name == "RateController" and any(each.name in PLANS for each in nodes[index : node.end]):
            return _port(node, "hz", 10.0)
    return 0.0


def _recoveries(nodes: list[_Node]) -> Iterator[RecoveryEntry]:
    """Return the recoveries: the last child of the outermost recovery node that has any, once for each retry."""
    for index, node in enumerate(nodes):
        if node.name != "RecoveryNode":
            continue
        children = [at for at in range(index + 1, node.end) if nodes[at].parent == index]
        groups = _groups(nodes, children[-1]) if len(children) > 1 else []
        if not any(groups):
            continue
        retries = max(1, int(_port(node, "number_of_retries", 1.0)))
        if any(each.ports.get("wrap_around", "").lower() == "false" for each in nodes[children[-1] : node.end]):
            retries = min(retries, len(groups))  # a round robin that tries each once
        names = _Names()
        count = 0
        for attempt in range(retries):
            for each in groups[attempt % len(groups)]:
                if count == MAX_RECOVERIES:
                    return
                yield names.named(each)
                count += 1
        return


def _groups(nodes: list[_Node], at: int) -> list[list[RecoveryEntry]]:
    """Return what runs at each attempt in turn: the children of a round robin, or else all each time."""
    robin = next((i for i in range(at, nodes[at].end) if nodes[i].name == "RoundRobin"), None)
    if robin is None:
        return [_actions(nodes, at, nodes[at].end)]
    children = [i for i in range(robin + 1, nodes[robin].end) if nodes[i].parent == robin]
    return [group for child in children if (group := _actions(nodes, child, nodes[child].end))]


def _actions(nodes: list[_Node], begin: int, end: int) -> list[RecoveryEntry]:
    """Return the recoveries among nodes; several that clear costmaps one after the other are one."""
    found: list[RecoveryEntry] = []
    for node in nodes[begin:end]:
        if node.name in CLEARS:
            distance = _port(node, "reset_distance", 1.0) if node.name == "ClearCostmapExceptRegion" else 0.0
            clear = RecoveryEntry(*CLEAR, {"reset_distance": distance})
            if found[-1:] != [clear]:
                found.append(clear)
        elif node.name in RECOVERIES:
            name, plugin, ports = RECOVERIES[node.name]
            values = {ours: _port(node, port, default) for port, (ours, default) in ports.items()}
            found.append(RecoveryEntry(name, plugin, values))
    return found


class _Names:
    """Gives recoveries with other parameters other names."""

    def __init__(self) -> None:
        self._taken: dict[str, dict[str, float]] = {}

    def named(self, recovery: RecoveryEntry) -> RecoveryEntry:
        number = 1
        while True:
            name = recovery.name if number == 1 else f"{recovery.name}_{number}"
            if self._taken.setdefault(name, recovery.parameters) == recovery.parameters:
                return msgspec.structs.replace(recovery, name=name)
            number += 1


def _port(node: _Node, port: str, default: float) -> float:
    """Return the number of a port; its default if the blackboard gives it, or if it is no number."""
    try:
        found = float(node.ports.get(port, ""))
    except ValueError:
        return default
    return found if abs(found) < float("inf") else default


def default_tree(rate: float = 1.0) -> Tree:
    """Return Nav2's own tree: it clears the costmaps, spins, waits and backs up in turn, at most six times."""
    clear = RecoveryEntry(*CLEAR, {"reset_distance": 0.0})
    spin = RecoveryEntry("spin", "rotate_recovery", {"spin_dist": 1.57})
    wait = RecoveryEntry("wait", "wait", {"wait_duration": 5.0})
    back_up = RecoveryEntry("backup", "back_up", {"backup_dist": 0.3, "backup_speed": 0.05})
    return Tree(rate, (clear, spin, wait, back_up, clear, spin), ())


def as_behaviors(recoveries: tuple[RecoveryEntry, ...]) -> list[dict[str, Any]]:
    """Return the list of Move Base."""
    return [{"name": each.name, "type": each.type} for each in recoveries]
