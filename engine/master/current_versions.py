"""Current versions of maps, and requests with them."""

from dataclasses import dataclass, field, replace

import msgspec

from engine.master.events import MapChanged
from engine.master.places import PlaceRequest
from engine.specs.containers import MapVersion, RobotConfig

MOST_KNOWN = 4096
"""Largest number of maps whose current versions are remembered."""


@dataclass(slots=True)
class CurrentVersions:
    """Current versions of the maps that changed last, by the numbers of their publications.

    Clients read the current version of a map and report it later; meanwhile another one may be published.
    """

    _known: dict[str, MapChanged] = field(default_factory=dict)

    def note(self, event: MapChanged) -> bool:
        """Note a version; return False if a later one is known."""
        known = self._known.pop(event.map.id, None)
        if known is not None and _order(event) < _order(known):
            self._known[event.map.id] = known
            return False
        self._known[event.map.id] = event
        if len(self._known) > MOST_KNOWN:
            del self._known[next(iter(self._known))]
        return True

    def of(self, request: PlaceRequest) -> PlaceRequest:
        """Return a request with the current versions of its map and masks; those that are not known stay as given."""
        for name in request.map_ids:
            if name in self._known:
                request = with_version(request, self._known[name])
        return request


def _order(event: MapChanged) -> tuple[int, bool]:
    return event.number, event.in_space is not None


def with_version(request: PlaceRequest, event: MapChanged) -> PlaceRequest:
    """Return the request of a robot or a group's node with the version of a map, if it uses that map.

    Otherwise return an equal request.
    """
    robot = request.robot
    if robot is None:
        follows = request.group_node != "" and request.map.id == event.map.id
        return replace(request, map=event.map) if follows else request
    if robot.new_map:
        return request
    robot = _with_masks(robot, event.map)
    if request.map.id != event.map.id:
        return replace(request, robot=robot)
    if event.in_space is not None:
        robot = msgspec.structs.replace(robot, in_space=event.in_space)
    return replace(request, map=event.map, robot=robot)


def _with_masks(robot: RobotConfig, version: MapVersion) -> RobotConfig:
    masks = {name: version if mask.id == version.id else mask for name, mask in robot.masks.items()}
    return msgspec.structs.replace(robot, masks=masks)
