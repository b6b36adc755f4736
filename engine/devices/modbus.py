"""Driver ``modbus:``: lifts and doors behind a PLC that speaks Modbus TCP; ``docs/lifts.md`` has the registers."""

import asyncio
from collections.abc import Callable, Mapping, Sequence
from typing import Any, ClassVar

from engine.devices.base import DeviceDriver, DeviceUrl, DoorDevice, LiftDevice
from engine.devices.hosts import DeviceHosts
from ppaas.buildings.building import DoorSettings, LiftSettings
from ppaas.buildings.doors.states import DOOR_MODES, DoorRequest, DoorState
from ppaas.buildings.lifts.states import DoorPosition, EndSession, LiftMode, LiftRequest, LiftState, Motion
from ppaas.distribution import install_hint
from ppaas.errors import InvalidInput, Unavailable

PORT = 502

TIMEOUT = 2.0
"""Time limit of a connection and of a request [s]."""

POLL = 0.5
"""Time between two readings of the state [s], if the option ``poll`` does not set another."""

FROZEN = 5.0
"""Time without a change of a PLC's counter after which its states are not taken for new [s]."""

DOORS: tuple[DoorPosition, ...] = ("closed", "moving", "open")

MOTIONS: tuple[Motion, ...] = ("stopped", "up", "down")

LIFT_MODES: tuple[LiftMode, ...] = ("unknown", "human", "agv", "fire", "offline", "emergency")
"""Modes by their numbers, as in ``rmf_lift_msgs``."""

FOREIGN = "modbus"
"""Session of a lift that says it is granted before this process has asked."""


class ModbusDriver(DeviceDriver):
    """Driver of ``modbus://HOST[:PORT]/UNIT``, with the options ``base`` (first register) and ``poll``."""

    extra: ClassVar[str | None] = "devices"

    def lift(
        self, url: DeviceUrl, settings: LiftSettings, levels: Mapping[str, float], hosts: DeviceHosts
    ) -> LiftDevice:
        """Return a lift behind a PLC."""
        return _ModbusLift(settings.lift, _numbers(url, levels), _Plc(url, hosts))

    def door(self, url: DeviceUrl, settings: DoorSettings, hosts: DeviceHosts) -> DoorDevice:
        """Return a door behind a PLC."""
        return _ModbusDoor(settings, _Plc(url, hosts))


def _numbers(url: DeviceUrl, levels: Mapping[str, float]) -> dict[str, int]:
    """Return the numbers of floors: from 0 upwards, if the option ``floors`` sets no others."""
    texts = url.floors or {floor: str(number) for number, floor in enumerate(levels)}
    numbers = {}
    for floor, text in texts.items():
        if not (text.isascii() and text.isdecimal() and int(text) < 1 << 16):
            raise InvalidInput(f"a floor is a number up to 65535 at a device of modbus:, not {text!r}")
        numbers[floor] = int(text)
    return numbers


class _Plc:
    """Registers of a PLC, over a connection that ``poll`` makes: a client does not retry a first one that failed."""

    def __init__(self, url: DeviceUrl, hosts: DeviceHosts) -> None:
        url.check_options("base", "poll")
        self._base = int(url.number("base", 0, 0, 65000))
        self._poll = url.number("poll", POLL, 0.05, 2.0)
        unit = url.path.strip("/") or "1"
        if not (unit.isascii() and unit.isdecimal() and int(unit) < 256):
            raise InvalidInput(f"the unit of a device of modbus: is a number up to 255, not {unit!r}")
        self._unit, self._url, self._hosts = int(unit), url, hosts
        self._name = f"modbus://{url.host}:{url.port or PORT}/{unit}"
        self._library = _imported()
        self._client: Any = None
        self._counter = 0

    async def poll(self, number: int, take: Callable[[Sequence[int]], None]) -> None:
        """Hand over input registers again and again, the last of which is a counter of the PLC, or always 0.

        Raises
        ------
        Unavailable
            The connection is lost, or the PLC does not answer as expected.
        """
        address = await self._hosts.address(self._url.host, self._url.port or PORT)
        client = self._library.client.AsyncModbusTcpClient(
            address, port=self._url.port or PORT, timeout=TIMEOUT, retries=0, reconnect_delay=0
        )
        try:
            if not await client.connect():
                raise Unavailable(f"{self._name} cannot be connected to")
            self._client = client
            counter, changed = 0, asyncio.get_running_loop().time()
            while True:
                registers = await self._exchange(client.read_input_registers, self._base, count=number)
                now = asyncio.get_running_loop().time()
                if registers[-1] != counter:
                    counter, changed = registers[-1], now
                if not counter or now - changed < FROZEN:
                    take(registers)
                await asyncio.sleep(self._poll)
        finally:
            self._client = None
            client.close()

    async def write(self, values: Sequence[int]) -> None:
        """Write holding registers, and a counter behind them that changes with each order."""
        if self._client is None:
            raise Unavailable(f"{self._name} is not connected")
        self._counter = self._counter % 65535 + 1
        await self._exchange(self._client.write_registers, self._base, [*values, self._counter])

    async def _exchange(self, call: Callable[..., Any], *arguments: Any, **options: Any) -> list[int]:
        try:
            answer = await call(*arguments, device_id=self._unit, **options)
        except self._library.ModbusException as error:
            raise Unavailable(f"{self._name}: {error}") from error
        if answer.isError():
            raise Unavailable(f"{self._name} answered with the exception {answer.exception_code}")
        return list(answer.registers)


class _ModbusLift(LiftDevice):
    def __init__(self, lift: str, numbers: Mapping[str, int], plc: _Plc) -> None:
        self._lift, self._numbers, self._plc = lift, numbers, plc
        self._floors = {number: floor for floor, number in numbers.items()}
        self._session = FOREIGN

    async def run(self, report: Callable[[LiftState], None]) -> None:
        await self._plc.poll(6, lambda registers: report(self._state(registers)))

    def _state(self, registers: Sequence[int]) -> LiftState:
        floor, door, motion, mode, granted = registers[:5]
        return LiftState(
            lift=self._lift,
            floor=self._floors.get(floor, ""),
            door=_at(DOORS, door, "moving"),
            motion=_at(MOTIONS, motion, "stopped"),
            mode=_at(LIFT_MODES, mode, "unknown"),
            session=self._session if granted else "",
        )

    async def send(self, order: LiftRequest | EndSession) -> None:
        self._session = order.session
        if isinstance(order, EndSession):
            await self._plc.write([0, 0, 0])
        elif order.floor in self._numbers:
            await self._plc.write([1, self._numbers[order.floor], 1])
        else:
            raise InvalidInput(f"the option 'floors' of lift {self._lift!r} has no floor {order.floor!r}")


class _ModbusDoor(DoorDevice):
    def __init__(self, settings: DoorSettings, plc: _Plc) -> None:
        self._settings, self._plc = settings, plc

    async def run(self, report: Callable[[DoorState], None]) -> None:
        await self._plc.poll(2, lambda registers: report(self._state(registers[0])))

    def _state(self, mode: int) -> DoorState:
        return DoorState(floor=self._settings.floor, door=self._settings.door, mode=_at(DOOR_MODES, mode, "unknown"))

    async def send(self, order: DoorRequest) -> None:
        await self._plc.write([1 if order.mode == "open" else 0])


def _at(names: tuple[Any, ...], number: int, other: Any) -> Any:
    return names[number] if number < len(names) else other


def _imported() -> Any:
    try:
        import pymodbus.client  # noqa: PLC0415 - of the extra devices
    except ImportError as error:
        raise InvalidInput(f"devices of modbus: need the extra devices: {install_hint('devices')}") from error
    return pymodbus
