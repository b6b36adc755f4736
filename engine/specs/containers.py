"""What the engine speaks of: machines, containers, and what a container is told at its start."""

from typing import Any, Literal

import msgspec

from ppaas.robot_model.description import RobotDescription

ContainerKind = Literal["robot", "planning"]
Heights = tuple[float | None, float]

SESSION_STATE = "session"
"""Name under which a checkpoint keeps the session that it was made in."""

ORIGIN_STATE = "origin"
"""Name under which a checkpoint keeps what it was made for, and by which cloud process."""

LINK_STATE = "link"
"""Name under which a checkpoint keeps the last sequence number that was applied."""


class MapVersion(msgspec.Struct, frozen=True):
    """One version of a map."""

    id: str
    version: str


class LayerSpec(msgspec.Struct, frozen=True):
    """Of what the layers of a map are made.

    Parameters
    ----------
    robot_radius : float
        For which it is inflated [m].
    masks : dict of str to MapVersion
        What lies on it, by the names of the costmap filters.
    heights : tuple of float, optional
        From where to where what its octomap has is in the way [m]; from one voxel on, if the first is None.
    """

    map: MapVersion
    robot_radius: float
    masks: dict[str, MapVersion] = {}
    heights: Heights | None = None


class RobotConfig(msgspec.Struct, frozen=True):
    """What a clone must know of its robot.

    Parameters
    ----------
    urdf : RobotDescription, optional
        What its URDF tells.
    masks : dict of str to MapVersion
        Which versions of masks its costmap filters go by, by the names of the filters.
    in_space : bool
        Whether its map has an octomap, too.
    """

    id: str
    model: str
    initial_pose: tuple[float, float, float]
    base_global_planner: str
    base_local_planner: str
    parameters: dict[str, Any] = {}
    urdf: RobotDescription | None = None
    masks: dict[str, MapVersion] = {}
    in_space: bool = False


class ContainerSpec(msgspec.Struct, frozen=True):
    """What to start.

    Parameters
    ----------
    id : str
        Unique among all containers, for ever.
    cores : float
        Size in CPU cores; decimal.
    robot : RobotConfig, optional
        The robot whose clone runs in it; without one it only plans.
    checkpoint : dict of str to bytes
        State of each node to go on from.
    session : str
        Id of the first container that filled the place: those that replace it go on from its checkpoints, and from
        no others.
    container_group : str
        Containers of one group are kept on one machine where a balancer can; without a name it is those of its map.
    labels : dict of str to str
        Its machine has all of these.
    """

    id: str
    user: str
    map: MapVersion
    cores: float
    robot: RobotConfig | None = None
    checkpoint: dict[str, bytes] = {}
    session: str = ""
    container_group: str = ""
    labels: dict[str, str] = {}

    @property
    def kind(self) -> ContainerKind:
        """``"robot"`` if a clone runs in it, else ``"planning"``."""
        return "planning" if self.robot is None else "robot"

    @property
    def group(self) -> str:
        """The group that it is in."""
        return self.container_group or f"{self.map.id}@{self.map.version}"

    @property
    def serves(self) -> str:
        """Whom it serves: a robot, or whoever plans on its map."""
        return f"{self.user}/{self.robot.id}" if self.robot is not None else self.user


class Launch(msgspec.Struct, frozen=True):
    """What a machine hands to the process that becomes a container.

    Parameters
    ----------
    layers : str
        Folder of the map's layers in shared memory.
    link : str
        Unix socket of the endpoint, to which the robot link is dialled; that handshake is *ready*.
    machine : str
        Unix socket of the machine, for what goes to the stores and to other containers.
    secret : str
        Shows both that the container is the one they await.
    cpus : tuple of int
        CPUs it may run on.
    threads : int
        Most threads its kernels may use.
    allowed : tuple of str
        Other people's plug-ins that may run in it, each as ``group:name`` of its entry point.
    """

    spec: ContainerSpec
    layers: str
    link: str
    machine: str
    secret: str
    cpus: tuple[int, ...]
    threads: int
    allowed: tuple[str, ...] = ()
