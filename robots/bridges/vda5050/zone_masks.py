"""Zones of a master control as masks that the robot's file names."""

import asyncio
from collections.abc import Awaitable, Callable, Mapping
from typing import Any

from ppaas.clock import monotonic
from ppaas.distribution import install_hint
from ppaas.errors import Conflict, InvalidInput, NotFound, Unavailable
from ppaas.maps.grid import GridMap
from ppaas.maps.occupancy import from_message
from ppaas.messages import decode
from ppaas.messages.nav_msgs import GetMapResponse
from ppaas.wire.vda5050.agv.zone_grids import SPEED_STEP, keepout_mask, marked_point, speed_mask
from ppaas.wire.vda5050.zones import Zones
from robots.client.cloud_url import path_of
from robots.client.rest import RestClient

KEEPOUT, SPEED = "keepout_filter", "speed_filter"

SETTINGS: dict[str, dict[str, Any]] = {KEEPOUT: {}, SPEED: {"type": 2, "base": 0, "multiplier": SPEED_STEP}}
"""Parameters of the masks besides their names."""

EFFECT_TIMEOUT = 20.0
"""Time within which a clone uses a new version of a mask [s]."""

LOOK_PERIOD = 0.5

Mask = Callable[[str], Awaitable[bytes]]
"""Returns the response of a service of the clone, ``keepout_filter_mask`` or ``speed_filter_mask``."""


class ZoneMasks:
    """Masks of one robot.

    Parameters
    ----------
    rest : RestClient
    robot : str
        Id of a robot of the user.
    radius : float
        Radius of the robot [m].
    """

    def __init__(self, rest: RestClient, robot: str, radius: float) -> None:
        self._rest, self._robot, self._radius = rest, robot, radius
        self._used: dict[str, GridMap] = {}
        self._ids = {KEEPOUT: f"{robot}-zones-keepout", SPEED: f"{robot}-zones-speed"}

    async def prepare(self, parameters: Mapping[str, Any]) -> None:
        """Publish masks without zones if there are none, and name them in the robot's file.

        Parameters
        ----------
        parameters : mapping
            Parameters of the robot's file.

        Raises
        ------
        Conflict
            The file names other masks.
        PPaaSError
            The cloud refuses it.
        """
        for name, own in self._ids.items():
            named = (parameters.get(name) or {}).get("filter_mask")
            if named not in (None, own):
                raise Conflict(f"the robot's file names the mask {named!r} in {name!r}: remove it to use zones")
            try:
                await self._rest.get(path_of("maps", own))
            except NotFound:
                await self._publish(own, keepout_mask(Zones(map_id="", zone_set_id="", zones=[])))
        named_masks = {name: {"filter_mask": own, **SETTINGS[name]} for name, own in self._ids.items()}
        await self._rest.patch(path_of("robots", self._robot), {"parameters": named_masks})

    async def use(self, zones: Zones, ask: Mask) -> None:
        """Publish zones as masks, and wait until the clone uses them.

        Raises
        ------
        Unavailable
            The clone does not use them: it was opened before its file named them.
        PPaaSError
            The cloud refuses it.
        """
        masks = {KEEPOUT: keepout_mask(zones), SPEED: speed_mask(zones, self._radius)}
        for name, mask in masks.items():
            await self._publish(self._ids[name], mask)
        deadline = monotonic() + EFFECT_TIMEOUT
        for name, mask in masks.items():
            while not await self._has_effect(name, mask, ask):
                if monotonic() > deadline:
                    raise Unavailable("the robot's clone does not use the zones yet: connect the robot again")
                await asyncio.sleep(LOOK_PERIOD)
        self._used = masks

    async def _has_effect(self, name: str, mask: GridMap, ask: Mask) -> bool:
        """Return whether the clone has the marks of a mask, and no longer the marks of the mask before."""
        points = [marked_point(one) for one in (mask, self._used.get(name)) if one is not None]
        wanted = [point for point in points if point is not None]
        if not wanted:
            return True
        answer = decode(GetMapResponse, await ask(f"{name}_mask")).map
        used = from_message(answer) if answer.info.width else None
        return all(_marks(used, point) == _marks(mask, point) for point in wanted)

    async def _publish(self, map_id: str, mask: GridMap) -> None:
        try:
            # Images and YAML are for zones alone.
            from ppaas.maps.formats.map_files import save_map  # noqa: PLC0415
        except ModuleNotFoundError as error:
            raise InvalidInput(f"zones need {error.name}: {install_hint('vda5050')}") from error
        yaml, image = save_map(mask, f"{map_id}.pgm")
        await self._rest.upload_map(map_id, yaml, image, message="zones of a master control")


def _marks(mask: GridMap | None, point: tuple[float, float]) -> bool:
    """Return whether a mask has an effect at a point [m]; a clone without masks answers with a grid without cells."""
    cell = None if mask is None else mask.info.cell_of(*point)
    return mask is not None and cell is not None and bool(mask.data[cell] > 0)
