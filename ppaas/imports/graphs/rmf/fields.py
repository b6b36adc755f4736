"""Fields of the buildings and navigation graphs of Open-RMF that both have: of vertices and of lanes."""

import math
from collections.abc import Mapping
from typing import Any

import yaml

from ppaas.errors import InvalidInput
from ppaas.imports.graphs.model.cleaning import GraphBuilder
from ppaas.imports.graphs.model.gathered import GatheredNotes
from ppaas.imports.graphs.model.route_graph import GraphEdge, GraphMark, GraphNode, GraphStation, Place, wrapped
from ppaas.imports.yaml_depth import check_depth

_LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)

USES: Mapping[str, str] = {
    "is_parking_spot": "park", "is_charger": "charge", "is_holding_point": "wait", "is_cleaning_zone": "clean",
    "pickup_dispenser": "pick", "dropoff_ingestor": "drop", "dock_name": "dock",
}  # fmt: skip
"""What a station is for, by the properties of its vertex that are true or not empty."""

PASSING = "is_passthrough_point"

_WITHOUT_EFFECT: Mapping[str, str] = {
    "spawn_robot_type": "simulated robots are not made of buildings",
    "spawn_robot_name": "simulated robots are not made of buildings",
    "human_goal_set_name": "goals of simulated people are not imported",
    "lift_cabin": "cars of lifts are areas, not vertices",
    "lift": "cars of lifts are areas, not vertices",
    "merge_radius": "robots begin on the lane that is nearest to them",
    "workcell_name": "work cells are not asked; tasks go to stations",
    "orientation": "robots choose their heading along lanes",
    "orientation_constraint": "robots choose their heading along lanes",
    "demo_mock_floor_name": "simulated lifts are not made of lanes",
    "demo_mock_lift_name": "simulated lifts are not made of lanes",
    "door_name": "doors are lines across the way, not lanes",
    "dock_name": "docks are at named vertices, not on lanes",
    "undock_name": "docks are at named vertices, not on lanes",
}

KNOWN = {
    *USES,
    PASSING,
    *_WITHOUT_EFFECT,
    "name",
    "bidirectional",
    "is_bidirectional",
    "graph_idx",
    "speed_limit",
    "mutex",
}


def load_yaml(content: bytes, source: str) -> Mapping[str, Any]:
    """Return the mapping in a file of YAML.

    Raises
    ------
    InvalidInput
        It is no YAML with a mapping; the text names the line.
    """
    try:
        check_depth(content, source)
        tree = yaml.load(content, _LOADER)
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        where = "" if mark is None else f"line {mark.line + 1}: "
        raise InvalidInput(f"{source} is no YAML: {where}{getattr(error, 'problem', '') or error!s:.200}") from error
    except (RecursionError, ValueError) as error:
        raise InvalidInput(f"{source} is no YAML that can be read: {error!s:.200}") from error
    if not isinstance(tree, dict):
        raise InvalidInput(f"{source} is YAML, but no mapping with levels")
    return tree


def levels_of(tree: Mapping[str, Any], source: str) -> dict[str, Mapping[str, Any]]:
    """Return the floors of a building or a navigation graph by name; ``InvalidInput`` if it has none."""
    found = tree.get("levels")
    levels: dict[str, Mapping[str, Any]] = (
        {str(name): each for name, each in found.items() if isinstance(each, dict)} if isinstance(found, dict) else {}
    )
    if not levels:
        raise InvalidInput(f"{source} has no levels")
    return levels


class RmfReader:
    """Reads vertices and lanes.

    Parameters
    ----------
    notes : GatheredNotes
    part : str
        Where they are in the file: ``levels.L1``.
    """

    def __init__(self, notes: GatheredNotes, part: str) -> None:
        self.builder = GraphBuilder(notes)
        self._notes, self._part = notes, part
        self._docks: dict[str, str] = {}
        self._charges: dict[str, bool] = {}
        self._backward: set[str] = set()

    def add_vertex(self, index: int, place: Place, name: str, properties: Mapping[str, Any]) -> None:
        """Add a vertex as a node, and as a station if it has a name or a use."""
        part = f"{self._part}.vertices[{index}]"
        if not self.builder.add_node(str(index), GraphNode(name or f"v{index}", place, part)):
            return
        uses = tuple(use for key, use in USES.items() if _is_set(properties.get(key)))
        if name or uses:
            called = f"{part} {name}".strip()
            self.builder.graph.stations.append(GraphStation(name or f"v{index}", place, None, uses, called))
        if _is_set(properties.get(PASSING)):
            self.builder.graph.passing.append(place)
            self._notes.translated(f"{part}.{PASSING}", "a zone in which robots do not stop")
        if _is_set(properties.get("is_charger")) or _is_set(properties.get("dock_name")):
            given = properties.get("dock_name")
            self._docks[str(index)] = given if isinstance(given, str) and given else f"{name or f'v{index}'} dock"
            self._charges[str(index)] = _is_set(properties.get("is_charger"))
        self._note_others(part, properties, USES)

    def add_docks(self) -> None:
        """Add a dock at each charger and each vertex with a ``dock_name``, with the heading of a lane that ends there.

        Call it once all lanes are added.
        """
        graph = self.builder.graph
        for key, name in self._docks.items():
            node = graph.nodes[key]
            lane = next((edge for edge in graph.edges if edge.end == key), None)
            if lane is None:
                self._notes.without_effect(f"{node.part} {name}", "no lane leads to it: draw a dock with its heading")
                continue
            (x0, y0), (x1, y1) = graph.nodes[lane.start].place, node.place
            yaw = math.atan2(y1 - y0, x1 - x0) + (math.pi if lane.part in self._backward else 0.0)
            charges = self._charges[key]
            mark = GraphMark(name, "dock", (node.place,), yaw=wrapped(yaw), charges=charges, part=f"{node.part} {name}")
            graph.marks.append(mark)

    def add_lane(self, index: int, ends: tuple[str, str], properties: Mapping[str, Any], *, both_ways: bool) -> None:
        """Add a lane as one or two edges."""
        part = f"{self._part}.lanes[{index}]"
        speed = number(properties.get("speed_limit"))
        group = properties.get("mutex")
        if properties.get("orientation") == "backward":
            self._backward.add(part)
        limit = speed if speed is not None and 0.0 < speed <= 100.0 else None
        mutex = group if isinstance(group, str) else ""
        edge = GraphEdge(f"lane {index}", *ends, (), limit, None, mutex, part)
        if not self.builder.add_edge(edge):
            return
        if both_ways:
            self.builder.add_edge(GraphEdge(f"lane {index}", ends[1], ends[0], (), limit, None, mutex, part))
        if limit is not None:
            self._notes.translated(f"{part}.speed_limit", f"a zone that limits the speed to {limit:g} m/s")
        if mutex:
            self._notes.translated(f"{part}.mutex", f"a zone for one robot at a time: {mutex}")
        self._note_others(part, properties, {})

    def _note_others(self, part: str, properties: Mapping[str, Any], used: Mapping[str, str]) -> None:
        for key, value in properties.items():
            if key in used or not _is_set(value):
                continue
            if key in _WITHOUT_EFFECT:
                self._notes.without_effect(f"{part}.{key}", _WITHOUT_EFFECT[key])
            elif key not in KNOWN:
                self._notes.without_effect(f"{part}.{key}", "no property of Open-RMF that is known here")


def _is_set(value: Any) -> bool:
    return bool(value)


def number(value: Any) -> float | None:
    """Return a finite number; None if it is none."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return None
    return float(value) if math.isfinite(value) else None


def index_of(value: Any) -> str:
    """Return the key of the vertex that a lane names."""
    found = number(value)
    return str(value) if found is None else str(int(found))


def items(level: Mapping[str, Any], name: str) -> list[Any]:
    """Return a list of a floor; empty if it has none."""
    found = level.get(name)
    return found if isinstance(found, list) else []
