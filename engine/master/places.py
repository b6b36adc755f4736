"""Places: what users hold, while containers fill them and are replaced."""

from dataclasses import dataclass, field
from typing import Literal

from engine.specs.containers import ContainerSpec, MapVersion, RobotConfig
from engine.specs.machine_settings import labels_text


def robot_key(user: str, robot: str) -> str:
    """Return the name of a robot's place."""
    return f"robot:{user}/{robot}"


@dataclass(frozen=True, slots=True)
class PlaceRequest:
    """Request for a place: its user, map version, size [cores], robot, and labels that its machine must have."""

    user: str
    map: MapVersion
    cores: float
    robot: RobotConfig | None = None
    labels: dict[str, str] = field(default_factory=dict)

    @property
    def key(self) -> str:
        """Name of the place: one for each robot; for planning, one for each user, map version and set of labels."""
        if self.robot is not None:
            return robot_key(self.user, self.robot.id)
        where = f" on {labels_text(self.labels)}" if self.labels else ""
        return f"planning:{self.user}/{self.map.id}@{self.map.version}{where}"


@dataclass(slots=True)
class Place:
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

    @property
    def cores(self) -> float:
        """Size of its containers [cores]."""
        return self.request.cores if self.resized is None else self.resized
