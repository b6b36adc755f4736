"""Driver ``sim:``: simulated lifts and doors in this process, for trials without hardware."""

import asyncio
from collections.abc import Callable, Mapping
from functools import cached_property
from typing import ClassVar

from engine.devices.base import DeviceDriver, DeviceUrl, DoorDevice, LiftDevice
from engine.devices.hosts import DeviceHosts
from ppaas.buildings.building import DoorSettings, LiftSettings
from ppaas.buildings.doors.simulated import SimulatedDoor
from ppaas.buildings.doors.states import DoorRequest, DoorState
from ppaas.buildings.lifts.simulated import LiftModel, SimulatedLift
from ppaas.buildings.lifts.states import EndSession, LiftRequest, LiftState

REPORT = 0.25
"""Time between two states [s]."""

NEVER = 1e9
"""Time after which nothing breaks [s]."""


class SimDriver(DeviceDriver):
    """Driver of ``sim:``.

    Options of lifts are ``people`` (trips an hour), ``wrong_floor`` (share), ``seed`` and ``breaks``: after how many
    seconds it goes out of order.
    """

    remote: ClassVar[bool] = False

    def lift(
        self, url: DeviceUrl, settings: LiftSettings, levels: Mapping[str, float], hosts: DeviceHosts
    ) -> LiftDevice:
        """Return a simulated lift."""
        url.check_options("people", "wrong_floor", "seed", "breaks")
        model = LiftModel(
            speed=settings.speed,
            doors=settings.doors,
            people=url.number("people", 0.0, 0.0, 3600.0),
            wrong_floor=url.number("wrong_floor", 0.0, 0.0, 1.0),
            seed=int(url.number("seed", 0, 0, 2**31)),
            breaks=url.number("breaks", NEVER, 0.0, NEVER),
        )
        return _SimLift(lambda now: SimulatedLift(settings.lift, levels, now, model))

    def door(self, url: DeviceUrl, settings: DoorSettings, hosts: DeviceHosts) -> DoorDevice:
        """Return a simulated door."""
        url.check_options()
        return _SimDoor(lambda now: SimulatedDoor(settings.floor, settings.door, now, settings.opens))


class _SimLift(LiftDevice):
    def __init__(self, made_at: Callable[[float], SimulatedLift]) -> None:
        self._made_at = made_at

    @cached_property
    def _lift(self) -> SimulatedLift:
        """The lift, whose time begins when it is used first: a device may be opened before there is an event loop."""
        return self._made_at(_now())

    async def run(self, report: Callable[[LiftState], None]) -> None:
        while True:
            report(self._lift.state(_now()))
            await asyncio.sleep(REPORT)

    async def send(self, order: LiftRequest | EndSession) -> None:
        if isinstance(order, EndSession):
            self._lift.end(order, _now())
        else:
            self._lift.request(order, _now())


class _SimDoor(DoorDevice):
    def __init__(self, made_at: Callable[[float], SimulatedDoor]) -> None:
        self._made_at = made_at

    @cached_property
    def _door(self) -> SimulatedDoor:
        """The door, made when it is used first, as a lift is."""
        return self._made_at(_now())

    async def run(self, report: Callable[[DoorState], None]) -> None:
        while True:
            report(self._door.state(_now()))
            await asyncio.sleep(REPORT)

    async def send(self, order: DoorRequest) -> None:
        self._door.request(order, _now())


def _now() -> float:
    """Return the time by the event loop [s], which goes on evenly when the computer's clock is set."""
    return asyncio.get_running_loop().time()
