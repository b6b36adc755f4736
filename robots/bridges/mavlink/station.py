"""This station of MAVLink: finds its vehicle among those at a port, and exchanges messages with it alone."""

import logging
import re
from collections.abc import Callable
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from typing import Any

from ppaas.bounded import BoundedDict
from ppaas.clock import monotonic
from ppaas.errors import Conflict, InvalidInput
from robots.bridges.core.notices import Notices
from robots.bridges.mavlink.dialect import COMPONENT, Parser, mavlink
from robots.bridges.mavlink.link import LINES, PeerWatch, VehicleAddress

logger = logging.getLogger("ppaas.bridge")

SEARCH = 2.5
"""Time for which vehicles are collected before one is taken without a number [s]; they send a heartbeat a second."""

MAX_PEERS = 32
"""Largest number of addresses whose bytes are kept apart."""

ROVERS = (mavlink.MAV_TYPE_GROUND_ROVER, mavlink.MAV_TYPE_SURFACE_BOAT)
"""Types of vehicles that drive; the modes of others have other numbers."""


@dataclass(frozen=True, slots=True)
class StationOptions:
    """Options of a station.

    Attributes
    ----------
    address : VehicleAddress
    system : int or None
        Number of the vehicle; None for the only one.
    station : int
        Number of this station.
    key : bytes or None
        Key of signatures.
    """

    address: VehicleAddress
    system: int | None = None
    station: int = 255
    key: bytes | None = None


_HEX = re.compile(r"[0-9A-Fa-f]{64}")


def key_of(path: Path) -> bytes:
    """Return the key of 32 bytes in a file: its hexadecimal digits, or the SHA-256 of its passphrase.

    Raises
    ------
    InvalidInput
        The file cannot be read, or is empty.
    """
    try:
        text = path.read_text().strip()
    except (OSError, UnicodeDecodeError) as error:
        raise InvalidInput(f"cannot read the key of {path}: {error}") from error
    if not text:
        raise InvalidInput(f"{path} has no key: write 64 hexadecimal digits or a passphrase into it")
    return bytes.fromhex(text) if _HEX.fullmatch(text) else sha256(text.encode()).digest()


def addressed(message: Any, station: int) -> bool:
    """Return whether a message is for all stations, or for the one with a number."""
    system, component = getattr(message, "target_system", 0), getattr(message, "target_component", 0)
    return system in (0, station) and component in (0, COMPONENT)


class Finder:
    """Finds the vehicle by heartbeats.

    Parameters
    ----------
    system : int or None
        Number of the vehicle; None for the only one.
    """

    def __init__(self, system: int | None) -> None:
        self._system = system
        self._since: float | None = None
        self.found: dict[int, Any] = {}

    def take(self, message: Any, now: float) -> None:
        """Take a heartbeat; stations, cameras and onboard computers are no vehicles."""
        is_vehicle = message.autopilot != mavlink.MAV_AUTOPILOT_INVALID and message.type != mavlink.MAV_TYPE_GCS
        system = message.get_srcSystem()
        if is_vehicle and self._system in (None, system):
            self._since = now if self._since is None else self._since
            self.found.setdefault(system, message)

    def choose(self, now: float) -> Any:
        """Return a heartbeat of the vehicle; None while it is not found.

        Raises
        ------
        Conflict
            There are several vehicles, or it is none that drives.
        """
        if self._since is None or (self._system is None and now - self._since < SEARCH):
            return None
        if len(self.found) > 1:
            numbers = ", ".join(map(str, sorted(self.found)))
            raise Conflict(f"vehicles {numbers} are at this port: choose one with --system")
        (heartbeat,) = self.found.values()
        if heartbeat.type not in ROVERS:
            entry = mavlink.enums["MAV_TYPE"].get(heartbeat.type)
            name = entry.name.removeprefix("MAV_TYPE_") if entry is not None else str(heartbeat.type)
            raise Conflict(f"vehicle {heartbeat.get_srcSystem()} is a {name}: the bridge drives rovers and boats alone")
        return heartbeat


class Station:
    """Exchange of messages with one vehicle.

    Parameters
    ----------
    options : StationOptions
    received : callable
        Called with each message of the vehicle, and its time of arrival [s].
    """

    def __init__(self, options: StationOptions, received: Callable[[Any, float], None]) -> None:
        self._options, self._received = options, received
        self._writer = Parser(options.station, options.key)
        self._parsers: BoundedDict[Any, Parser] = BoundedDict(MAX_PEERS)
        self._peer, self._notices = PeerWatch(), Notices()
        self._began = monotonic()
        self.finder = Finder(options.system)
        self._found_at: BoundedDict[int, Any] = BoundedDict(MAX_PEERS)
        self.system = 0
        self.forged = 0
        self.line = LINES[options.address.kind](options.address, self.receive)

    def choose(self, system: int) -> None:
        """Take the messages of one vehicle from now on."""
        self.system = system
        if system in self._found_at:
            self._peer.is_it(self._found_at[system])  # so that the first heartbeat of this station is sent at once

    def receive(self, data: bytes, address: Any) -> None:
        """Take bytes from an address."""
        parser = self._parsers.get(address)
        if parser is None:
            parser = self._parsers[address] = Parser(self._options.station, self._options.key)
        now, forged = monotonic(), parser.forged
        for message in parser.read(data):
            self._take(message, address, now)
        if parser.forged > forged:
            self.forged += parser.forged - forged
            self._notices.warn(
                "messages are left out: they are not signed with the key of --signing-key-file, or were sent before"
            )

    def send(self, message: Any) -> None:
        """Send a message to the vehicle; before it is found, to the end of a line that has one end."""
        data = self._writer.write(message)
        if self._peer.address is not None or self._options.address.kind != "udpin":
            self.line.send(data, self._peer.address)

    def is_addressed_by(self, message: Any) -> bool:
        """Return whether a message is for all stations, or for this one."""
        return addressed(message, self._options.station)

    def boot_ms(self) -> int:
        """Return the time of this station [ms]."""
        return round(1e3 * (monotonic() - self._began)) & 0xFFFFFFFF

    def heartbeat(self) -> None:
        """Send the heartbeat of a ground station."""
        self.send(
            mavlink.MAVLink_heartbeat_message(
                mavlink.MAV_TYPE_GCS, mavlink.MAV_AUTOPILOT_INVALID, 0, 0, mavlink.MAV_STATE_ACTIVE, 3
            )
        )

    def _take(self, message: Any, address: Any, now: float) -> None:
        system = message.get_srcSystem()
        if not self.system:
            if message.get_type() == "HEARTBEAT":
                self.finder.take(message, now)
                self._found_at[system] = address
            return
        if system != self.system:
            is_vehicle = message.get_type() == "HEARTBEAT" and message.autopilot != mavlink.MAV_AUTOPILOT_INVALID
            if is_vehicle and system not in self.finder.found:
                self.finder.found[system] = message
                logger.warning("vehicle %d is at this port, too; the bridge drives %d", system, self.system)
            return
        if not self._peer.is_it(address):
            self._notices.warn(f"another vehicle with the number {system} sends from {address}: it is left out")
            return
        self._received(message, now)
