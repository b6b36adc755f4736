"""Topics and versions: ``interface/majorVersion/manufacturer/serialNumber/topic``, and what two sides share."""

import re
from dataclasses import dataclass
from enum import StrEnum
from typing import Self

from ppaas.errors import InvalidInput, NotFound

# -- versions of VDA 5050, and which of them two sides share -----------------------------------------------------------


class Version(StrEnum):
    """Version of VDA 5050, spelled as in the header of a message."""

    V2_0 = "2.0.0"
    V2_1 = "2.1.0"
    V3_0 = "3.0.0"

    @property
    def major(self) -> int:
        """Major version: 2 or 3. Topics and most names of fields depend on it."""
        return int(self.value[0])

    @property
    def interface(self) -> str:
        """First level of topics, as the specification proposes it."""
        return "uagv" if self is not Version.V3_0 else "vda5050"


_FORM = re.compile(r"v?(\d{1,4})(?:\.(\d{1,4})(?:\.[\w.+-]{1,40})?)?")


def version_of(text: str) -> Version:
    """Return the version to speak with a side that names its own.

    Minor versions of one major version understand each other, so an unknown one counts as the newest known.

    Parameters
    ----------
    text : str
        Version as in a header (``2.1.0``), a topic (``v2``) or an option (``2.1``).

    Raises
    ------
    NotFound
        The major version is not known; 1 is not served.
    """
    form = _FORM.fullmatch(text)
    major, minor = (int(form[1]), form[2]) if form else (0, None)
    if major == 2:
        return Version.V2_0 if minor is not None and int(minor) == 0 else Version.V2_1
    if major == 3:
        return Version.V3_0
    raise NotFound("version of VDA 5050", text, [*Version])


def understand(own: Version, text: str) -> bool:
    """Return whether a message whose header names version ``text`` can be read by a side of version ``own``."""
    try:
        return version_of(text).major == own.major
    except NotFound:
        return False


# -- topics of VDA 5050 ------------------------------------------------------------------------------------------------

ORDER = "order"
INSTANT_ACTIONS = "instantActions"
STATE = "state"
CONNECTION = "connection"
FACTSHEET = "factsheet"
VISUALIZATION = "visualization"
RESPONSES = "responses"
ZONE_SET = "zoneSet"

TO_AGV = (ORDER, INSTANT_ACTIONS)
"""Topics that a master control publishes in all versions."""

TO_AGV_3 = (*TO_AGV, RESPONSES, ZONE_SET)
"""Topics that a master control publishes in 3.0."""

FROM_AGV = (STATE, CONNECTION, FACTSHEET, VISUALIZATION)
"""Topics that an AGV publishes."""

MAX_LEVEL = 200
"""Largest length of a level of a topic [characters]."""


def topics_to_agv(version: Version) -> tuple[str, ...]:
    """Return the topics that an AGV of a version subscribes to."""
    return TO_AGV_3 if version.major >= 3 else TO_AGV


def quality_of(topic: str) -> tuple[int, bool]:
    """Return the quality of service of a topic, and whether its messages are retained."""
    return (1, True) if topic == CONNECTION else (0, False)


@dataclass(frozen=True, slots=True)
class AgvAddress:
    """Address of an AGV: the levels of its topics before the last.

    Attributes
    ----------
    interface : str
        Name of the interface: ``uagv`` (2.x), ``vda5050`` (3.0), or another one by agreement.
    major : str
        Major version with its letter, as ``v2``.
    manufacturer, serial : str
        Manufacturer and serial number of the AGV.
    """

    interface: str
    major: str
    manufacturer: str
    serial: str

    @classmethod
    def of(cls, version: Version, manufacturer: str, serial: str, interface: str = "") -> Self:
        """Return an address.

        Parameters
        ----------
        interface : str
            Name of the interface; empty for the version's.

        Raises
        ------
        InvalidInput
            A level is empty, too long, or has a character with a special meaning in MQTT.
        """
        names = interface or version.interface, manufacturer, serial
        for kind, name in zip(("interface", "manufacturer", "serial number"), names, strict=True):
            _check(kind, name)
        return cls(names[0], f"v{version.major}", manufacturer, serial)

    @property
    def agv(self) -> str:
        """Name of the AGV: manufacturer and serial number, with a slash between them."""
        return f"{self.manufacturer}/{self.serial}"

    def topic(self, name: str) -> str:
        """Return the whole name of a topic."""
        return "/".join((self.interface, self.major, self.manufacturer, self.serial, name))


def parse_topic(topic: str) -> tuple[AgvAddress, str]:
    """Return the address and the last level of a topic.

    Raises
    ------
    InvalidInput
        The topic has another number of levels, or an empty one.
    """
    levels = topic.split("/")
    if len(levels) != 5 or not all(levels):
        raise InvalidInput(f"topic {topic[:MAX_LEVEL]!r} is not interface/version/manufacturer/serialNumber/topic")
    return AgvAddress(*levels[:4]), levels[4]


def _check(kind: str, name: str) -> None:
    if not name or len(name) > MAX_LEVEL or not name.isprintable() or set(name) & set("/+#$"):
        raise InvalidInput(
            f"the {kind} {name[:MAX_LEVEL]!r} cannot be a level of a topic: give 1 to {MAX_LEVEL} characters "
            "without '/', '+', '#' and '$'"
        )
