"""Bytes to and from vehicles: UDP, TCP or a serial line, which is opened again when it is lost."""

import asyncio
import logging
import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from ppaas.clock import monotonic
from ppaas.distribution import install_hint
from ppaas.errors import InvalidInput, Unavailable

logger = logging.getLogger("ppaas.bridge")

BAUD = 57600
"""Usual speed of a telemetry radio [baud]."""

MOST_BAUD = 12_000_000
"""Largest speed of a serial line [baud], of USB at full speed."""

RETRY = 2.0
"""Time after which a lost connection is opened again [s]."""

PEER_SILENT = 3.0
"""Time without a message from a vehicle's address after which it may have another one [s]."""

CHUNK = 4096

Received = Callable[[bytes, Any], None]
"""Called with bytes, and with the address that they came from; None for a line that has one end."""


@dataclass(frozen=True, slots=True)
class VehicleAddress:
    """Where vehicles are: ``udpin``, ``udpout`` or ``tcp`` with host and port, or a serial device with its baud."""

    kind: str
    host: str
    port: int

    @classmethod
    def parse(cls, text: str) -> "VehicleAddress":
        """Return the address of a text, as MAVProxy and QGroundControl write it.

        Raises
        ------
        InvalidInput
            It is none; the text says how one is written.
        """
        kind, _, rest = text.partition(":")
        if kind in ("udpin", "udpout", "tcp"):
            host, _, port = rest.rpartition(":")
            if _is_host(host) and _is_number(port, 65535):
                return cls(kind, host, int(port))
        elif text.startswith("/"):
            device, _, baud = text.partition(",")
            if not baud or _is_number(baud, MOST_BAUD):
                return cls("serial", device, int(baud or BAUD))
        raise InvalidInput(
            f"no address of a vehicle: {text!r}; give udpin:HOST:PORT, udpout:HOST:PORT, tcp:HOST:PORT or "
            "/dev/DEVICE[,BAUD]"
        )


def _is_host(text: str) -> bool:
    """Return whether a text may name a host: the look-up of others fails without an error of the network."""
    try:
        return bool(text.encode("idna"))
    except UnicodeError:
        return False


def _is_number(text: str, most: int) -> bool:
    return text.isdecimal() and len(text) < 10 and 0 < int(text) <= most


class VehicleLine(ABC):
    """Way to the vehicles.

    Parameters
    ----------
    address : VehicleAddress
    received : callable
        Called with what comes.
    """

    def __init__(self, address: VehicleAddress, received: Received) -> None:
        self._address, self._received = address, received

    @abstractmethod
    async def run(self) -> None:
        """Carry bytes until cancelled.

        Raises
        ------
        Unavailable
            It cannot be opened, and never will.
        """

    @abstractmethod
    def send(self, data: bytes, to: Any) -> None:
        """Send a message to an address that bytes came from; without effect while the line is not open."""


class _Datagrams(asyncio.DatagramProtocol):
    def __init__(self, received: Received) -> None:
        self._received = received

    def datagram_received(self, data: bytes, addr: Any) -> None:
        self._received(data, addr)

    def error_received(self, exc: Exception) -> None:
        logger.debug("a vehicle cannot be reached: %s", exc)


class UdpLine(VehicleLine):
    """UDP: a port at which vehicles report, or the port of a vehicle."""

    def __init__(self, address: VehicleAddress, received: Received) -> None:
        super().__init__(address, received)
        self._transport: asyncio.DatagramTransport | None = None

    async def run(self) -> None:
        """Carry bytes until cancelled; raises ``Unavailable`` if the port is in use."""
        here = (self._address.host, self._address.port)
        ends: dict[str, Any] = {"local_addr": here} if self._address.kind == "udpin" else {"remote_addr": here}
        loop = asyncio.get_running_loop()
        try:
            self._transport, _ = await loop.create_datagram_endpoint(lambda: _Datagrams(self._received), **ends)
        except OSError as error:
            raise Unavailable(f"cannot open {self._address.kind}:{here[0]}:{here[1]}: {error}") from error
        try:
            await loop.create_future()
        finally:
            self._transport.close()

    def send(self, data: bytes, to: Any) -> None:
        """Send to the vehicle alone, not to other stations at the port."""
        if self._transport is not None and not self._transport.is_closing():
            self._transport.sendto(data, to if self._address.kind == "udpin" else None)


class TcpLine(VehicleLine):
    """TCP to a vehicle or a router, which is connected again when it is lost."""

    def __init__(self, address: VehicleAddress, received: Received) -> None:
        super().__init__(address, received)
        self._writer: asyncio.StreamWriter | None = None
        self._problem = ""

    async def run(self) -> None:
        """Carry bytes until cancelled."""
        while True:
            try:
                reader, self._writer = await asyncio.open_connection(self._address.host, self._address.port)
                self._tell("")
                while data := await reader.read(CHUNK):
                    self._received(data, None)
                self._tell("the vehicle has closed the connection")
            except OSError as error:
                self._tell(str(error))
            finally:
                if self._writer is not None:
                    self._writer.close()
                    self._writer = None
            await asyncio.sleep(RETRY)

    def send(self, data: bytes, to: Any) -> None:
        """Send, unless the vehicle takes nothing."""
        if self._writer is not None and self._writer.transport.get_write_buffer_size() < CHUNK:
            self._writer.write(data)

    def _tell(self, problem: str) -> None:
        if problem and problem != self._problem:
            logger.warning("tcp:%s:%d: %s", self._address.host, self._address.port, problem)
        self._problem = problem


class SerialLine(VehicleLine):
    """Serial line, such as a telemetry radio, which may be pulled out and plugged in again."""

    def __init__(self, address: VehicleAddress, received: Received) -> None:
        super().__init__(address, received)
        self._port: Any = None
        self._lost = asyncio.Event()

    async def run(self) -> None:
        """Carry bytes until cancelled; raises ``Unavailable`` if pyserial is not there."""
        try:
            import serial  # noqa: PLC0415 - only lines of this kind need it
        except ModuleNotFoundError as error:
            raise Unavailable(f"serial lines need the extra mavlink: {install_hint('mavlink')}") from error
        loop, told = asyncio.get_running_loop(), ""
        while True:
            self._lost.clear()
            try:
                self._port = serial.Serial(self._address.host, self._address.port, timeout=0, write_timeout=0)
            except (OSError, ValueError) as error:
                if str(error) != told:
                    logger.warning("%s", error)
                told = str(error)
            else:
                told, descriptor = "", self._port.fileno()
                loop.add_reader(descriptor, self._readable)
                try:
                    await self._lost.wait()
                finally:
                    loop.remove_reader(descriptor)
                    self._port.close()
                    self._port = None
            await asyncio.sleep(RETRY)

    def send(self, data: bytes, to: Any) -> None:
        """Send; what a slow line does not take now is lost."""
        try:
            if self._port is not None:
                self._port.write(data)
        except OSError as error:  # serial.SerialException, also of a full line
            logger.debug("%s: %s", self._address.host, error)

    def _readable(self) -> None:
        try:
            data = self._port.read(CHUNK)
        except OSError as error:
            logger.warning("%s: %s", self._address.host, error)
            data = b""
        if data:
            self._received(data, None)
        else:
            self._lost.set()


LINES: dict[str, type[VehicleLine]] = {"udpin": UdpLine, "udpout": UdpLine, "tcp": TcpLine, "serial": SerialLine}


class PeerWatch:
    """Keeps to the address of a vehicle: two vehicles with one number must not be mixed up."""

    def __init__(self) -> None:
        self.address: Any = None
        self._heard_at = -math.inf

    def is_it(self, address: Any) -> bool:
        """Return whether a message of the vehicle's number is the vehicle's."""
        now = monotonic()
        if address != self.address and now - self._heard_at < PEER_SILENT:
            return False
        self.address, self._heard_at = address, now
        return True
