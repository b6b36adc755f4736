"""Causes of lethal places: the map, a keep-out zone by its name, a mask, the octomap, a robot, a person, a sensor.

Layers keep no cause for each cell. It is looked for when a plan is refused: the nearest cell that is lethal made it so.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.maps.grid import OCCUPIED, GridInfo
from ppaas.zones.zone import KeepOut, Zone

if TYPE_CHECKING:
    from ppaas.costmap.map_layers import MapLayers

Kind = Literal["map", "zone", "mask", "octomap", "robot", "person", "sensor"]

REACH = 3.0
"""Distance from a place up to which causes are looked for [m]."""

_KINDS: tuple[Kind, ...] = ("zone", "mask", "octomap", "robot", "person", "map", "sensor")
"""Causes in the order in which they count where several are equally near: sensors see walls, robots and people, too."""

_NOUNS = {
    "map": "an obstacle of the map",
    "zone": "the keep-out zone {}",
    "mask": "a keep-out mask",
    "octomap": "an obstacle of the octomap at the height of the robot",
    "robot": "robot {}",
    "person": "a person",
    "sensor": "an obstacle that the sensors see",
}


class Cause(NamedTuple):
    """What makes a place lethal.

    Parameters
    ----------
    kind : str
    name : str
        Name of the zone or robot; empty if it has none.
    distance : float
        Distance to it [m]; 0 within it.
    """

    kind: Kind
    name: str
    distance: float

    @property
    def text(self) -> str:
        """What it is, in words."""
        if self.kind == "robot" and not self.name:
            return "another robot"
        return _NOUNS[self.kind].format(repr(self.name) if self.kind == "zone" else self.name)


class Body(NamedTuple):
    """Another robot or a person: a disc in the frame of the map [m], and its name if that is known."""

    kind: Kind
    x: float
    y: float
    radius: float
    name: str = ""


@dataclass(frozen=True, slots=True)
class Causes:
    """Causes around a robot at a moment, or the causes of a map alone.

    Parameters
    ----------
    layers : MapLayers
    bodies : sequence of Body
        Other robots and people.
    seen : (n, 2) float array, optional
        Points that sensors see, in the frame of the map [m].
    """

    layers: "MapLayers"
    bodies: Sequence[Body] = ()
    seen: NDArray[np.float64] | None = None

    def __call__(self, x: float, y: float) -> Cause | None:
        """Return the nearest cause at a place in the frame of the map [m]; None if there is none within `REACH`."""
        found = [*self._of_map(x, y), *self._of_bodies(x, y), *self._of_sensors(x, y)]
        near = [cause for cause in found if cause.distance <= REACH]
        slack = self.layers.grid.info.resolution
        return min(near, key=lambda one: (max(one.distance - slack, 0.0), _KINDS.index(one.kind)), default=None)

    def _of_map(self, x: float, y: float) -> Iterator[Cause]:
        cell = self.layers.grid.info.cell_of(x, y)
        if cell is None:
            return
        yield from barriers_at(self.layers, x, y, REACH)
        yield Cause("map", "", float(self.layers.distance[cell]))

    def _of_bodies(self, x: float, y: float) -> Iterator[Cause]:
        for body in self.bodies:
            apart = float(np.hypot(body.x - x, body.y - y)) - body.radius
            yield Cause(body.kind, body.name, max(apart, 0.0))

    def _of_sensors(self, x: float, y: float) -> Iterator[Cause]:
        if self.seen is not None and len(self.seen):
            apart = float(np.hypot(self.seen[:, 0] - x, self.seen[:, 1] - y).min())
            yield Cause("sensor", "", max(apart - self.layers.grid.info.resolution, 0.0))


def barriers_at(layers: "MapLayers", x: float, y: float, within: float) -> list[Cause]:
    """Return the keep-out zones, the mask and the obstacles of an octomap within a distance of a place, nearest first.

    A zone counts if the layers bar it now: it has no times, or is in force. Cells in a zone count as the zone alone.

    Parameters
    ----------
    layers : MapLayers
    x, y : float
        Place in the frame of the map [m].
    within : float
        Distance [m].
    """
    if layers.keepout is None:
        return []
    info = layers.grid.info
    cells = _barred_near(layers.keepout.data, info, (x, y), within)
    barred = info.to_world(cells).reshape(-1, 2)
    zones = list(kept_out_zones(layers, barred))
    found = [Cause("zone", zone.name, float(zone.area.distances(np.array([(x, y)]))[0])) for zone in zones]
    in_none = np.ones(len(cells), np.bool_)
    for zone in zones:
        in_none &= zone.area.distances(barred) > _reach(info)
    apart = np.hypot(barred[:, 0] - x, barred[:, 1] - y)
    of_octomap = np.zeros(len(cells), np.bool_)
    if layers.overhead is not None:
        of_octomap = layers.overhead.data[cells[:, 0], cells[:, 1]] == OCCUPIED
    kinds: tuple[tuple[Kind, NDArray[np.bool_]], ...] = (("octomap", of_octomap), ("mask", ~of_octomap))
    found += [Cause(kind, "", float(apart[of & in_none].min())) for kind, of in kinds if (of & in_none).any()]
    return sorted((cause for cause in found if cause.distance <= within), key=lambda one: one.distance)


def _reach(info: GridInfo) -> float:
    """Return the distance from a zone up to which the centre of a cell that it bars lies [m]."""
    return float(0.51 * np.sqrt(2.0) * info.resolution)


def kept_out_zones(layers: "MapLayers", barred: NDArray[np.float64]) -> Iterator[Zone]:
    """Yield the keep-out zones that touch some of (n, 2) centres of barred cells [m]."""
    reach = _reach(layers.grid.info)
    for zone in layers.zones.zones:
        if not isinstance(zone.rule, KeepOut):
            continue
        area = zone.area
        near = barred[((barred >= area.low - reach) & (barred <= area.high + reach)).all(axis=1)]
        if len(near) and bool((area.distances(near) <= reach).any()):
            yield zone


def _barred_near(
    keepout: NDArray[np.int8], info: GridInfo, place: tuple[float, float], within: float
) -> NDArray[np.int64]:
    """Return the (n, 2) cells of a keep-out mask that bar a place within a distance [m]."""
    row, column = (int(index) for index in info.to_cells(place))
    reach = int(within / info.resolution) + 1
    top, left = max(row - reach, 0), max(column - reach, 0)
    window = keepout[top : max(row + reach + 1, 0), left : max(column + reach + 1, 0)]
    cells = np.argwhere(window == OCCUPIED) + np.array((top, left))
    centres = info.to_world(cells).reshape(-1, 2)
    near: NDArray[np.int64] = cells[np.hypot(centres[:, 0] - place[0], centres[:, 1] - place[1]) <= within]
    return near
