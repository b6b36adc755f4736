"""Places: what users have, whatever containers fill them."""

from dataclasses import dataclass, field
from typing import Literal

from engine.specs.containers import ContainerSpec, MapVersion, RobotConfig
from engine.specs.machine_settings import labels_text


def robot_key(user: str, robot: str) -> str:
    """Return the name of a robot's place."""
    return f"robot:{user}/{robot}"


@dataclass(frozen=True, slots=True)
class PlaceRequest:
    """What a place is for; its machine has all of the labels."""

    user: str
    map: MapVersion
    cores: float
    robot: RobotConfig | None = None
    labels: dict[str, str] = field(default_factory=dict)

    @property
    def key(self) -> str:
        """Name of the place: one a robot, and one a user, map version and choice of labels for planning."""
        if self.robot is not None:
            return robot_key(self.user, self.robot.id)
        where = f" on {labels_text(self.labels)}" if self.labels else ""
        return f"planning:{self.user}/{self.map.id}@{self.map.version}{where}"


@dataclass(slots=True)
class Place:
    """A place and the container that fills it now, if one does.

    One whose container is to move has a ``successor``, a machine and what it keeps room for, from the order to leave
    until the container is gone. One whose container was ``resized`` keeps that size [cores].
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

    @property
    def cores(self) -> float:
        """Size of its containers."""
        return self.request.cores if self.resized is None else self.resized
