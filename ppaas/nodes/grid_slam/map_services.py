"""Map of ``grid_slam`` for others: it is published as it grows, and ``dynamic_map`` and ``save_map`` return it."""

from collections.abc import Callable

from ppaas.errors import PPaaSError, QuotaExceeded, Unavailable
from ppaas.mapping.live.live_mapper import LiveMapper
from ppaas.maps.grid import GridMap
from ppaas.maps.occupancy import to_message
from ppaas.messages.base.message import Message
from ppaas.messages.base.std_msgs import Time
from ppaas.messages.nav_msgs import GetMap, GetMapResponse
from ppaas.messages.slam_toolbox import SaveMap, SaveMapRequest, SaveMapResponse, SaveMapResult
from ppaas.nodes.base import Context, Reply, Service
from ppaas.nodes.frames import MAP
from ppaas.nodes.grid_slam.map_publisher import MapPublisher
from ppaas.nodes.grid_slam.messages import no_map

DYNAMIC_MAP = Service("dynamic_map", GetMap)
SAVE_MAP = Service("save_map", SaveMap)
SERVICES = (DYNAMIC_MAP, SAVE_MAP)

MapSaver = Callable[[str, GridMap, Callable[[PPaaSError | None], None]], None]
"""Saves a map by its name, then calls back with None or the error, now or later."""


class MapServices:
    """Draws the map of a mapper, publishes it, and answers ``dynamic_map`` and ``save_map``.

    Parameters
    ----------
    context : Context
        Of the node.
    interval : float
        Time between two publications of the whole map [s].
    save : callable, optional
        Saves a map for ``save_map``; without it the service is unavailable.

    Attributes
    ----------
    problem : str
        Reason for which the map is not complete; empty if it is.
    """

    def __init__(self, context: Context, interval: float, save: MapSaver | None = None) -> None:
        self.problem = ""
        self._context, self._save = context, save
        self._publisher = MapPublisher(context, interval)

    def publish(self, mapper: LiveMapper) -> None:
        """Publish what has changed in the map. If it would be too large, `problem` says so."""
        try:
            canvas = mapper.draw()
        except QuotaExceeded as error:
            self.problem = f"the map is not complete: {error}"
            return
        self._publisher.publish(canvas)

    def answer(self, request: Message, mapper: LiveMapper | None, reply: Reply) -> None:
        """Reply to a call of ``dynamic_map`` or ``save_map``; without a mapper, that there is no map.

        Raises
        ------
        Unavailable
            Maps cannot be saved here.
        QuotaExceeded
            The map would be too large.
        """
        if isinstance(request, SaveMapRequest):
            self._save_map(request.name.data, mapper, reply)
            return
        grid, stamp = _grid(mapper), Time.of(self._context.now())
        reply(GetMapResponse(no_map() if grid is None else to_message(grid, MAP, stamp)))

    def forget(self) -> None:
        """Forget the map, which was cleared."""
        self.problem = ""
        self._publisher.forget()

    def _save_map(self, name: str, mapper: LiveMapper | None, reply: Reply) -> None:
        if self._save is None:
            raise Unavailable("maps cannot be saved here: get the map by 'dynamic_map'")
        grid = _grid(mapper)
        if grid is None:
            reply(SaveMapResponse(SaveMapResult.RESULT_NO_MAP_RECEIEVD))
            return
        self._save(name, grid, lambda error: reply(error or SaveMapResponse(SaveMapResult.RESULT_SUCCESS)))


def _grid(mapper: LiveMapper | None) -> GridMap | None:
    """Return a copy of the map; None if there is none yet."""
    canvas = None if mapper is None else mapper.draw()
    return None if canvas is None or canvas.extent is None else GridMap(canvas.cells.copy(), canvas.info)
