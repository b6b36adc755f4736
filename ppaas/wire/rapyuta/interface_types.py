"""Types of interfaces: role in ROS, and where the interface is; which two may be joined.

An interface in a container stands for a topic or service of its ROS graph. A converter or a forwarder is on a robot,
which exchanges messages by it. A role is the interface's role in the graph of its own endpoint: the publisher on a
robot publishes there what comes from the cloud.

Source: ``rce/slave/interface.py``, ``rce/monitor/interface/robot.py``.
"""

from enum import StrEnum
from typing import NamedTuple

from ppaas.errors import InvalidInput


class InterfaceRole(StrEnum):
    """Role of an interface in the graph of its endpoint."""

    SERVICE_CLIENT = "ServiceClient"
    SERVICE_PROVIDER = "ServiceProvider"
    PUBLISHER = "Publisher"
    SUBSCRIBER = "Subscriber"


class InterfaceForm(StrEnum):
    """Form of an interface: in a container, or on a robot with messages as JSON or serialized as in ROS."""

    INTERFACE = "Interface"
    CONVERTER = "Converter"
    FORWARDER = "Forwarder"


PARTNERS = {
    InterfaceRole.SERVICE_CLIENT: InterfaceRole.SERVICE_PROVIDER,
    InterfaceRole.SERVICE_PROVIDER: InterfaceRole.SERVICE_CLIENT,
    InterfaceRole.PUBLISHER: InterfaceRole.SUBSCRIBER,
    InterfaceRole.SUBSCRIBER: InterfaceRole.PUBLISHER,
}
"""Role that a role may be joined with."""


class InterfaceType(NamedTuple):
    """Type of an interface, such as ``PublisherConverter``."""

    role: InterfaceRole
    form: InterfaceForm

    def __str__(self) -> str:
        """Return the name of the type."""
        return f"{self.role}{self.form}"

    @property
    def is_service(self) -> bool:
        """Whether it is for a service; else it is for a topic."""
        return self.role in (InterfaceRole.SERVICE_CLIENT, InterfaceRole.SERVICE_PROVIDER)


TYPES = {str(kind): kind for kind in (InterfaceType(role, form) for role in InterfaceRole for form in InterfaceForm)}
"""Types by name."""


def interface_type(name: str) -> InterfaceType:
    """Return the type with this name.

    Raises
    ------
    InvalidInput
        There is no such type.
    """
    known = TYPES.get(name)
    if known is None:
        raise InvalidInput(
            f"Interface type {name[:64]!r} is invalid: write one of {', '.join(InterfaceRole)}, followed by one of "
            f"{', '.join(InterfaceForm)}"
        )
    return known


def check_joinable(one: tuple[InterfaceType, str], other: tuple[InterfaceType, str]) -> None:
    """Raise unless two interfaces, each given by type and class name, may be joined.

    Raises
    ------
    InvalidInput
        Their roles do not match, or their messages have different classes.
    """
    (kind, name), (other_kind, other_name) = one, other
    if PARTNERS[kind.role] is not other_kind.role:
        raise InvalidInput(
            f"Can not connect an interface of type {kind} with one of type {other_kind}: "
            f"{kind.role} needs {PARTNERS[kind.role]}"
        )
    if name != other_name:
        raise InvalidInput(f"Can not connect two interfaces with different classes: {name} and {other_name}")
