"""Registry of types by ROS name, spelled as in ROS 1 (``geometry_msgs/Pose``) or ROS 2 (``geometry_msgs/msg/Pose``)."""

from types import ModuleType

from ppaas.errors import UnknownType
from ppaas.messages import (
    actionlib_msgs,
    explore_msgs,
    geometry_msgs,
    move_base_msgs,
    nav2_motions,
    nav2_msgs,
    nav2_servers,
    nav_msgs,
    octomap_msgs,
    people_coordination,
    people_msgs,
    ppaas_msgs,
    sensor_msgs,
    slam_toolbox,
    std_srvs,
    tf2_msgs,
    tf2_web_republisher,
    vision_msgs,
)
from ppaas.messages.base import map_msgs, rosapi, std_msgs
from ppaas.messages.base.message import Message, ServiceType
from ppaas.messages.fleet import fleet_plans, floors, traffic
from ppaas.messages.health import diagnostic_msgs, stops, watching
from ppaas.messages.operators import teleoperation

_PACKAGES: tuple[ModuleType, ...] = (
    std_msgs, geometry_msgs, nav_msgs, sensor_msgs, actionlib_msgs, move_base_msgs, nav2_msgs, tf2_msgs, ppaas_msgs,
    people_msgs, std_srvs, rosapi, tf2_web_republisher, map_msgs, slam_toolbox, explore_msgs,
    octomap_msgs, vision_msgs, people_coordination, diagnostic_msgs, watching, nav2_motions,
    traffic, fleet_plans, floors, stops, teleoperation, nav2_servers,
)  # fmt: skip


def _package_of(module: ModuleType) -> str:
    """Return the ROS package of a module: its name, unless it is one of several modules of a package."""
    package: str = getattr(module, "PACKAGE", module.__name__.rpartition(".")[2])
    return package


def _collect() -> dict[str, type[Message]]:
    types: dict[str, type[Message]] = {}
    for module in _PACKAGES:
        for value in vars(module).values():
            own = isinstance(value, type) and issubclass(value, Message) and value is not Message
            if own and (value.__module__ == module.__name__ or (value is std_msgs.Empty and module is std_msgs)):
                types[f"{_package_of(module)}/{value.__name__}"] = value
    return types


_TYPES = _collect()
_NAMES = {cls: name for name, cls in _TYPES.items()}
_SERVICES: dict[str, ServiceType] = {
    service.name: service for module in _PACKAGES for service in getattr(module, "SERVICES", ())
}


PACKAGES_OF_ROS_2 = {"rosapi_msgs": "rosapi", "tf2_web_republisher_interfaces": "tf2_web_republisher"}
"""ROS 1 names of the packages that have another name in ROS 2, by that name."""


def _ros1_spelling(name: str) -> str:
    package, _, rest = name.replace("/msg/", "/", 1).replace("/srv/", "/", 1).partition("/")
    return f"{PACKAGES_OF_ROS_2.get(package, package)}/{rest}"


def message_type(name: str) -> type[Message]:
    """Return the class of a ROS message type.

    Raises
    ------
    UnknownType
        The type is unknown; the text lists the types of its package.
    """
    known = _TYPES.get(_ros1_spelling(name))
    if known is None:
        package = name.partition("/")[0]
        near = sorted(n for n in _TYPES if n.startswith(f"{package}/")) or sorted({n.split("/")[0] for n in _TYPES})
        raise UnknownType(f"unknown message type {name!r}; known: {', '.join(near)}")
    return known


def service_type(name: str) -> ServiceType:
    """Return a ROS service type.

    Raises
    ------
    UnknownType
        The service type is unknown; the text lists the known ones.
    """
    known = _SERVICES.get(_ros1_spelling(name))
    if known is None:
        raise UnknownType(f"unknown service type {name!r}; known: {', '.join(sorted(_SERVICES))}")
    return known


def type_name(message: Message | type[Message]) -> str:
    """Return the type of a message as spelled in ROS 1."""
    return _NAMES[message if isinstance(message, type) else type(message)]


def message_types() -> tuple[str, ...]:
    """Return the sorted names of all message types."""
    return tuple(sorted(_TYPES))


def service_types() -> tuple[str, ...]:
    """Return the sorted names of all service types."""
    return tuple(sorted(_SERVICES))
