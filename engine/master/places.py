"""Places: what users hold, while containers fill them and are replaced."""

from dataclasses import dataclass, field
from typing import Literal

from engine.specs.containers import ContainerSpec, GroupNode, MapVersion, RobotConfig
from engine.specs.machine_settings import labels_text

CRASH_LIMIT = 5
CRASH_WINDOW = 30.0
"""More than `CRASH_LIMIT` crashes within `CRASH_WINDOW` [s] are a crash loop: the place is closed."""

RESTART_DELAYS = (0.0, 0.25, 1.0, 2.0, 4.0)
"""Delay of the restart after the first, second, … crash within the window [s]. A store that is unreachable for a moment
is back before the place is closed."""


LINGER = 30.0
"""Time for which the place of a robot outlives its last client [s]."""


def people_key(user: str, map_id: str) -> str:
    """Return the name of the place of the coordinator of a user's robots on a map."""
    return f"people:{user}/{map_id}"


def traffic_key(user: str, map_id: str) -> str:
    """Return the name of the place of the traffic node of a user's robots on a map."""
    return f"traffic:{user}/{map_id}"


def group_key(node: GroupNode, user: str, map_id: str) -> str:
    """Return the name of the place of a node of a user's robots on a map."""
    return people_key(user, map_id) if node == "people" else traffic_key(user, map_id)


def robot_key(user: str, robot: str) -> str:
    """Return the name of a robot's place."""
    return f"robot:{user}/{robot}"


def robot_of(key: str) -> tuple[str, str]:
    """Return user and id of the robot of a place with such a name."""
    user, _, robot = key.removeprefix("robot:").partition("/")
    return user, robot


@dataclass(frozen=True, slots=True)
class PlaceRequest:
    """Request for a place.

    Parameters
    ----------
    user : str
    map : MapVersion
    cores : float
        Size of its containers [cores].
    robot : RobotConfig, optional
        Robot whose clone it is for.
    labels : dict of str to str
        Labels that its machine must have.
    group_node : {"", "people", "traffic"}
        Node of the user's robots on the map that it is for: their people coordinator, or their traffic node. It keeps
        no settings: each container gets those that are stored when it starts.
    """

    user: str
    map: MapVersion
    cores: float
    robot: RobotConfig | None = None
    labels: dict[str, str] = field(default_factory=dict)
    group_node: GroupNode = ""

    @property
    def lasts(self) -> bool:
        """Whether its containers continue from checkpoints and outlive the cloud process; those that plan do not."""
        return self.robot is not None or self.group_node != ""

    @property
    def map_ids(self) -> tuple[str, ...]:
        """Ids of its map and of the masks of its robot, each once; its versions change, these do not."""
        masks = () if self.robot is None else (mask.id for mask in self.robot.masks.values())
        return tuple(dict.fromkeys((self.map.id, *masks)))

    @property
    def key(self) -> str:
        """Name of the place: one for each robot, and for each node of a user's robots on a map.

        For planning, one for each user, map version and set of labels.
        """
        if self.robot is not None:
            return robot_key(self.user, self.robot.id)
        if self.group_node:
            return group_key(self.group_node, self.user, self.map.id)
        where = f" on {labels_text(self.labels)}" if self.labels else ""
        return f"planning:{self.user}/{self.map.id}@{self.map.version}{where}"


@dataclass(slots=True)
class PlaceAssignment:
    """A place, and the container that fills it now, if any.

    Attributes
    ----------
    spec, machine, pid : optional
        Its container, the machine and the process id of it.
    crashes : list of float
        Times of the last crashes [monotonic s].
    session : str
        Session of all its containers; empty before the first.
    leaving : bool
        Whether its container was ordered to leave its machine.
    successor : tuple of str and ContainerSpec, optional
        Machine and spec of the next container, for which room is reserved until the leaving one has ended.
    resized : float, optional
        Size of its containers after a resize [cores].
    follows : bool
        Whether a map changed while its container started, which has the version before.
    moves : bool
        Whether its robot has moved to another map while its container started, which has the one before.
    """

    request: PlaceRequest
    spec: ContainerSpec | None = None
    machine: str | None = None
    state: Literal["waiting", "starting", "ready"] = "waiting"
    pid: int | None = None
    crashes: list[float] = field(default_factory=list)
    session: str = ""
    leaving: bool = False
    successor: tuple[str, ContainerSpec] | None = None
    resized: float | None = None
    follows: bool = False
    moves: bool = False

    @property
    def cores(self) -> float:
        """Size of its containers [cores]."""
        return self.request.cores if self.resized is None else self.resized


def note_crash(place: PlaceAssignment, now: float) -> float | None:
    """Count a crash; return the delay until the container is replaced [s], or None in a crash loop."""
    place.crashes = [t for t in place.crashes if now - t < CRASH_WINDOW] + [now]
    crashes = len(place.crashes)
    return RESTART_DELAYS[crashes - 1] if crashes <= CRASH_LIMIT else None
