"""Maps of tasks: where robots charge and park on them, and lengths of ways by the costs of planners."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from engine.control.planning.requests import CostAnswer
from engine.specs.containers import MapVersion
from ppaas.decoding import from_json
from ppaas.energy.sites import NO_SITES, Sites, sites_of
from ppaas.errors import NotFound
from ppaas.maps.formats.map_yaml import parse_yaml
from ppaas.tasks.assignment import Distance
from ppaas.tasks.floors import on_floor
from ppaas.tasks.records import Place
from ppaas.tasks.ways import ways_by
from storage.map_port import MapStore
from storage.versions import YAML, ZONES


class TaskMap(NamedTuple):
    """Version of a map on which tasks are done: where robots charge and park, and the size of a cell [m].

    The size is None if the map is removed or has no grid; distances are straight lines then.
    """

    version: MapVersion
    sites: Sites = NO_SITES
    resolution: float | None = None


def task_map_on(maps: MapStore, version: MapVersion) -> TaskMap:
    """Return what tasks need of a version of a map, the current one if it is empty, without its image; may block."""
    try:
        with maps.open_map(version.id, version.version or None, only=(YAML, ZONES)) as opened:
            resolution = parse_yaml(bytes(opened.buffers[YAML])).resolution if YAML in opened.buffers else None
            return TaskMap(version, sites_of(opened.zones()), resolution)
    except NotFound:
        return TaskMap(version)


def distance_by(answer: CostAnswer, starts: Sequence[Place], goals: Sequence[Place], resolution: float) -> Distance:
    """Return the lengths of the ways of a matrix of costs that a container answered, as ``ways_by``."""
    return ways_by(starts, goals, from_json(bytes(answer.costs), list[list[float | None]]), resolution)


def sites_on_floors(maps: Mapping[str, TaskMap]) -> Sites:
    """Return where robots charge and park on all floors, whose maps are given; names that two floors have are kept."""
    if list(maps) == [""]:
        return maps[""].sites
    chargers = {(floor, name): place for floor, on in maps.items() for name, place in on.sites.chargers.items()}
    parking = {(floor, name): place for floor, on in maps.items() for name, place in on.sites.parking.items()}
    return Sites(_named(chargers), _named(parking))


def _named(places: Mapping[tuple[str, str], Place]) -> dict[str, Place]:
    return {f"{floor}/{name}": on_floor(place, floor) for (floor, name), place in places.items()}
