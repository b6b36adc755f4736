"""Interface of devices: plug-ins that reach lifts and doors by URL."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import ClassVar
from urllib.parse import parse_qsl, urlsplit

from engine.devices.hosts import DeviceHosts
from ppaas.buildings.building import DoorSettings, LiftSettings
from ppaas.buildings.doors.states import DoorRequest, DoorState
from ppaas.buildings.lifts.states import EndSession, LiftRequest, LiftState
from ppaas.errors import InvalidInput


class LiftDevice(ABC):
    """Lift that a controller sends to floors."""

    @abstractmethod
    async def run(self, report: Callable[[LiftState], None]) -> None:
        """Report states of the lift, at least every 2 s, until cancelled.

        Raises
        ------
        Unavailable
            The lift cannot be reached, or not any more; it is run again after a while.
        """

    @abstractmethod
    async def send(self, order: LiftRequest | EndSession) -> None:
        """Send an order to the lift.

        Raises
        ------
        Unavailable
            The lift cannot be reached; a request is repeated by the controller.
        """


class DoorDevice(ABC):
    """Door that a controller opens."""

    @abstractmethod
    async def run(self, report: Callable[[DoorState], None]) -> None:
        """Report states of the door, at least every 2 s, until cancelled; raise as for lifts."""

    @abstractmethod
    async def send(self, order: DoorRequest) -> None:
        """Send an order to the door; raise as for lifts."""


@dataclass(frozen=True, slots=True)
class DeviceUrl:
    """URL of a device, in parts.

    Parameters
    ----------
    scheme, host, path : str
    port : int, optional
    user : str
    options : mapping of str to str
        Options of its query, such as ``poll=1``.
    floors : mapping of str to str
        Names that the device has for floors, by the names in the building: the option ``floors=L1:1,L2:2``.
    """

    scheme: str
    host: str
    path: str
    port: int | None = None
    user: str = ""
    options: Mapping[str, str] = field(default_factory=dict)
    floors: Mapping[str, str] = field(default_factory=dict)

    @classmethod
    def parse(cls, url: str) -> "DeviceUrl":
        """Read a URL.

        Raises
        ------
        InvalidInput
            It is not valid, or has a password, which everybody who reads the building would see.
        """
        try:
            parts = urlsplit(url)
            port = parts.port
            options = dict(parse_qsl(parts.query, keep_blank_values=True, strict_parsing=bool(parts.query)))
        except ValueError as error:
            raise InvalidInput(f"the URL of a device is not valid: {error}") from error
        if parts.password is not None:
            raise InvalidInput("the URL of a device may have no password: all who see the building can read it")
        pairs = [pair.rpartition(":") for pair in options.pop("floors", "").split(",") if pair]
        if any(not ours or not theirs for ours, _, theirs in pairs):
            raise InvalidInput("name the floors of a device as FLOOR:NAME,FLOOR:NAME, the floor of the building first")
        floors = {ours: theirs for ours, _, theirs in pairs}
        if len(set(floors.values())) != len(floors):
            raise InvalidInput("two floors have one name at the device")
        return cls(parts.scheme, parts.hostname or "", parts.path, port, parts.username or "", options, floors)

    def number(self, option: str, default: float, least: float, most: float) -> float:
        """Return an option that is a number.

        Raises
        ------
        InvalidInput
            It is not a number in the range.
        """
        try:
            value = float(self.options.get(option, default))
        except ValueError:
            value = float("nan")
        if not least <= value <= most:
            raise InvalidInput(f"option {option!r} of a device is a number from {least:g} to {most:g}")
        return value

    def check_options(self, *known: str) -> None:
        """Raise ``InvalidInput`` if the URL has an option that its plug-in does not know."""
        unknown = sorted(self.options.keys() - set(known))
        if unknown:
            raise InvalidInput(
                f"a device of {self.scheme}: has no option {unknown[0]!r}; options: {', '.join((*known, 'floors'))}"
            )

    def theirs(self, floor: str) -> str:
        """Return how the device names a floor."""
        return self.floors.get(floor, floor)

    def ours(self, floor: str) -> str:
        """Return the floor of the building that a device names."""
        return next((ours for ours, theirs in self.floors.items() if theirs == floor), floor)


class DeviceDriver(ABC):
    """Opens the devices of a URL scheme, which is the name of its entry point in the group ``ppaas.devices``.

    A driver imports its library when it opens a device.

    Attributes
    ----------
    extra : str, optional
        Extra of this project that installs the library of one of its own drivers.
    remote : bool
        Whether its devices have a host, which the operator must allow.
    """

    extra: ClassVar[str | None] = None
    remote: ClassVar[bool] = True

    @abstractmethod
    def lift(
        self, url: DeviceUrl, settings: LiftSettings, levels: Mapping[str, float], hosts: DeviceHosts
    ) -> LiftDevice:
        """Return a lift, not connected yet.

        Parameters
        ----------
        url : DeviceUrl
        settings : LiftSettings
        levels : mapping of str to float
            Height of each floor where it stops [m], the lowest first.
        hosts : DeviceHosts
            Asked for each address that is connected to.

        Raises
        ------
        InvalidInput
            The URL is not valid, or a library is not installed.
        """

    @abstractmethod
    def door(self, url: DeviceUrl, settings: DoorSettings, hosts: DeviceHosts) -> DoorDevice:
        """Return a door, not connected yet; raise as for lifts."""
