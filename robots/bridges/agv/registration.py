"""Registration of AGVs as robots of the account, by their factsheets."""

import asyncio
import logging
import math
from collections import defaultdict
from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager
from typing import Any

from ppaas.errors import Conflict, NotFound
from ppaas.robot_model.known_models import robot_model
from ppaas.wire.vda5050.factsheets import Factsheet, PhysicalParameters
from ppaas.wire.vda5050.topics import AgvAddress
from robots.bridges.agv.options import FleetOptions
from robots.client.cloud_url import path_of
from robots.client.rest import RestClient
from robots.client.robot_file import RobotFile

logger = logging.getLogger(__name__)

CORES = 0.25
"""Size of the container of an AGV [CPU cores]: it only plans."""

SAME_SIZE = 0.01
"""Difference up to which two radii are one [m]."""


class AgvRegistry:
    """Robots of the account that AGVs are: a robot is one AGV, by its manufacturer and its serial number.

    Parameters
    ----------
    rest : RestClient
    options : FleetOptions

    Attributes
    ----------
    unreadable : dict of AgvAddress to str
        Why the factsheet of an AGV cannot be read.
    """

    def __init__(self, rest: RestClient, options: FleetOptions) -> None:
        self.unreadable: dict[AgvAddress, str] = {}
        self._rest, self._options = rest, options
        self._used: dict[str, AgvAddress] = {}
        self._turns: defaultdict[str, asyncio.Lock] = defaultdict(asyncio.Lock)

    @asynccontextmanager
    async def robot(self, address: AgvAddress, map_id: str, sheet: Factsheet | None) -> AsyncIterator[dict[str, Any]]:
        """Yield the robot of an AGV as the cloud has it, which is registered now if it was not; no other AGV gets it.

        Parameters
        ----------
        address : AgvAddress
            Address of the AGV.
        map_id : str
            Map of the AGV, as it names it.
        sheet : Factsheet or None
            Factsheet of the AGV.

        Raises
        ------
        NotFound
            The robot is not registered, and is not to be.
        Conflict
            The robot is another AGV, its file does not say that it follows paths itself, or its size is not known.
        PPaaSError
            The cloud refuses the robot's file.
        """
        names = self._options.robots_of(address)
        async with self._turns[names[0]]:
            known = await self._known(names, address, map_id, sheet)
            robot = str(known["id"])
            self._used[robot] = address
        try:
            if "follow_path" not in known.get("parameters", {}):
                raise Conflict(
                    f'robot {robot!r} is driven by velocities: add "follow_path": {{}} to the parameters in its file'
                )
            yield known
        finally:
            del self._used[robot]

    async def _known(
        self, names: tuple[str, ...], address: AgvAddress, map_id: str, sheet: Factsheet | None
    ) -> dict[str, Any]:
        found = {name: await self._get(name) for name in names}
        for known in found.values():
            if known is not None and owner_of(known) == (address.manufacturer, address.serial):
                return self._unused(known, address)
        others = {name: other for name, known in found.items() if (other := self._other(name, known, address))}
        name = next((name for name in names if name not in others), None)
        if name is None or (others and found[name] is None and not self._options.register):
            raise _is_other(names[0], others[names[0]], address)
        known = found[name]
        if known is None:
            return await self._register(name, address, map_id, sheet)
        if self._options.robots:
            return known
        return await self._named(name, address)

    async def _get(self, name: str) -> dict[str, Any] | None:
        try:
            known: dict[str, Any] = await self._rest.get(path_of("robots", name))
        except NotFound:
            return None
        return known

    def _unused(self, known: dict[str, Any], address: AgvAddress) -> dict[str, Any]:
        other = self._used.get(str(known["id"]), address)
        if other != address:
            raise _is_other(str(known["id"]), other.agv, address)
        return known

    def _other(self, name: str, known: Mapping[str, Any] | None, address: AgvAddress) -> str:
        """Return the AGV that a robot is, if it is another one; empty if it may be this one."""
        used = self._used.get(name, address)
        if used != address:
            return used.agv
        named = (None, None) if known is None else owner_of(known)
        differs = any(
            one not in (None, own) for one, own in zip(named, (address.manufacturer, address.serial), strict=True)
        )
        return "/".join(part or "?" for part in named) if differs else ""

    async def _register(self, name: str, address: AgvAddress, map_id: str, sheet: Factsheet | None) -> dict[str, Any]:
        if not self._options.register:
            raise NotFound("robot", name)
        why = self.unreadable.get(address)
        if sheet is None and self._options.radius is None and why is not None:
            raise Conflict(f"its size is not known: give --radius, or mend its factsheet: {why}")
        await self._rest.put_robot(name, robot_file(address, self._options.map_of(map_id), sheet, self._options.radius))
        logger.info("registered AGV %s as robot %s", address.agv, name)
        return await self._checked(name, address)

    async def _named(self, name: str, address: AgvAddress) -> dict[str, Any]:
        """Write whose a robot is into its file, which names no AGV: later no other AGV is taken as this robot."""
        await self._rest.patch(path_of("robots", name), {"properties": {"vda5050": names_of(address)}})
        logger.info("robot %s is AGV %s from now on, which is written in its file", name, address.agv)
        return await self._checked(name, address)

    async def _checked(self, name: str, address: AgvAddress) -> dict[str, Any]:
        """Return a robot that was written, unless another bridge has written it since."""
        known: dict[str, Any] = await self._rest.get(path_of("robots", name))
        if other := self._other(name, known, address):
            raise _is_other(name, other, address)
        return known


def _is_other(robot: str, other: str, address: AgvAddress) -> Conflict:
    return Conflict(
        f"robot {robot!r} is AGV {other!r} by its file or by this bridge, not {address.agv!r}: name another robot for "
        f"this AGV with --agv {address.agv}=ROBOT, or correct properties.vda5050 in the file"
    )


def owner_of(known: Mapping[str, Any]) -> tuple[str | None, str | None]:
    """Return manufacturer and serial number of the AGV that a robot is by its file; None for what it does not say."""
    named = known.get("properties", {}).get("vda5050")
    if not isinstance(named, Mapping):
        return None, None
    maker, serial = named.get("manufacturer"), named.get("serialNumber")
    return None if maker is None else str(maker), None if serial is None else str(serial)


def names_of(address: AgvAddress) -> dict[str, str]:
    """Return manufacturer and serial number of an AGV, as a robot's file has them in ``properties.vda5050``."""
    return {"manufacturer": address.manufacturer, "serialNumber": address.serial}


def radius_of(body: PhysicalParameters) -> float:
    """Return the radius of the circle around length and width of an AGV [m]."""
    return 0.5 * math.hypot(body.length, body.width)


def differences(known: Mapping[str, Any], sheet: Factsheet | None) -> tuple[str, ...]:
    """Return how the file of a robot differs from the factsheet of its AGV, in words."""
    costmap = known.get("parameters", {}).get("global_costmap", {})
    body = None if sheet is None else sheet.physical_parameters
    if body is None or "footprint" in costmap:
        return ()
    filed = costmap.get("robot_radius", robot_model(str(known["model"])).robot_radius)
    if abs(filed - radius_of(body)) <= SAME_SIZE:
        return ()
    return (
        f"the radius is {filed:.2f} m by the robot's file, and {radius_of(body):.2f} m by the factsheet "
        f"({body.length:.2f} x {body.width:.2f} m): correct global_costmap.robot_radius in the file unless it is meant",
    )


def robot_file(address: AgvAddress, map_id: str, sheet: Factsheet | None, radius: float | None) -> RobotFile:
    """Return the file of the robot that an AGV is; the radius [m] belongs to the circle around its factsheet's size."""
    sizes: dict[str, Any] = {}
    if sheet is not None and sheet.physical_parameters is not None:
        radius = radius_of(sheet.physical_parameters)
    if radius is not None:
        sizes = {"global_costmap": {"robot_radius": radius}}
    return RobotFile(
        map=map_id,
        cores=CORES,
        parameters={"follow_path": {}, **sizes},
        description=f"AGV {address.agv}, by VDA 5050",
        properties={"vda5050": names_of(address)},
    )
