"""Specifications of containers, map layers and robots, and the launch of a container."""

from typing import Any, Literal

import msgspec

from ppaas.costmap.global_parameters import CostParameters
from ppaas.messages.health.stops import RobotStop
from ppaas.nodes.frames import BASE_LINK, FrameNames
from ppaas.people.names import coordinator_checkpoint
from ppaas.people.settings import PeopleSettings
from ppaas.robot_model.description import RobotDescription
from ppaas.tracing.spans import Sampling
from ppaas.traffic.taking_part import traffic_checkpoint, with_traffic

ContainerKind = Literal["robot", "planning", "coordinator", "traffic"]

GroupNode = Literal["", "people", "traffic"]
"""Node of a group, the robots of one user on one map: their people coordinator, or their traffic node. Empty: none."""

Heights = tuple[float | None, float]

SESSION_STATE = "session"
"""Key in a checkpoint: the session that it was made in."""

ORIGIN_STATE = "origin"
"""Key in a checkpoint: its ``Origin``."""

SESSIONS_STATE = "sessions"
"""Key of the sessions of clients in a checkpoint."""

LINK_STATE = "link"
"""Key in a checkpoint: the last sequence number of the robot link that was applied."""

LOG_STATE = "log"
"""Key in a checkpoint: the session in which the logs of its nodes began, if it is an earlier one."""

MOVED_STATE = "moved"
"""Key in a checkpoint: it was made on another map, or the robot was put elsewhere since."""


class MapVersion(msgspec.Struct, frozen=True):
    """One version of a map."""

    id: str
    version: str


class LayerSpec(msgspec.Struct, frozen=True):
    """Inputs of the layers of a map.

    Parameters
    ----------
    robot_radius : float
        Radius for the inflation [m].
    masks : dict of str to MapVersion
        Masks, by the names of the costmap filters.
    heights : tuple of float, optional
        Range of heights in which voxels of the octomap are obstacles [m]. Without the first it begins at one voxel.
    costs : CostParameters
        Parameters of the costs.
    posegraph : bool
        Whether the pose graph of the map is wanted instead of layers.
    """

    map: MapVersion
    robot_radius: float
    masks: dict[str, MapVersion] = {}
    heights: Heights | None = None
    costs: CostParameters = CostParameters()
    posegraph: bool = False


class RobotConfig(msgspec.Struct, frozen=True):
    """Configuration of a robot, for its clone.

    Parameters
    ----------
    urdf : RobotDescription, optional
        Description from its URDF.
    urdf_text : bytes
        The URDF itself, compressed by zlib; empty if it has none.
    masks : dict of str to MapVersion
        Versions of the masks, by the names of the costmap filters.
    in_space : bool
        Whether its map also has an octomap.
    new_map : str
        Id under which the map that the robot makes is to be published; empty on a published map.
    continued : MapVersion, optional
        Published map with a pose graph that this map continues; its robots share their positions.
    map_owner : str
        User whose robots may join maps of the same name with the new map: this one, or another who shares the published
        map of that id with this one. Empty for this one.
    """

    id: str
    model: str
    initial_pose: tuple[float, float, float]
    base_global_planner: str
    base_local_planner: str
    parameters: dict[str, Any] = {}
    urdf: RobotDescription | None = None
    urdf_text: bytes = b""
    masks: dict[str, MapVersion] = {}
    in_space: bool = False
    new_map: str = ""
    continued: MapVersion | None = None
    map_owner: str = ""

    @property
    def anywhere(self) -> "RobotConfig":
        """This configuration without what belongs to the map: a robot that has moved to another one has the same."""
        parameters = with_traffic(self.parameters, False)
        return msgspec.structs.replace(
            self, initial_pose=(0.0, 0.0, 0.0), masks={}, in_space=False, parameters=parameters
        )


class ContainerSpec(msgspec.Struct, frozen=True):
    """Specification of a container.

    Parameters
    ----------
    id : str
        Unique id, never reused.
    map : MapVersion
        The map; for a robot that makes a new one, its name in the robot file, without a version.
    cores : float
        Size [CPU cores], a decimal number.
    robot : RobotConfig, optional
        Robot whose clone runs in it. Without one, it only plans, or has the node of a group.
    checkpoint : dict of str to bytes
        Initial state of each node.
    session : str
        Id of the first container in the same place. Its replacements continue only from checkpoints of this session.
    container_group : str
        Containers of one group are placed on the same machine if possible. Default: the group of its map version; a
        robot that makes a new map is alone.
    labels : dict of str to str
        Labels that its machine must have.
    people : PeopleSettings, optional
        Settings of the people coordinator in it, for the user's robots on the map. None if it has none.
    traffic : bool
        Whether the traffic node of the user's robots on the map runs in it.
    stops : tuple of RobotStop
        Stops that apply to its robot when it starts.
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
    people: PeopleSettings | None = None
    traffic: bool = False
    stops: tuple[RobotStop, ...] = ()

    @property
    def group_node(self) -> GroupNode:
        """Node of a group that runs in it; empty if it has none."""
        if self.people is not None:
            return "people"
        return "traffic" if self.traffic else ""

    @property
    def kind(self) -> ContainerKind:
        """``"robot"`` for a clone, ``"coordinator"`` or ``"traffic"`` for the node of a group, else ``"planning"``."""
        if self.robot is not None:
            return "robot"
        return _KINDS[self.group_node]

    @property
    def checkpoint_name(self) -> str:
        """Name of its checkpoints among its user's: the robot's or the group's; empty if it only plans."""
        if self.robot is not None:
            return self.robot.id
        match self.group_node:
            case "people":
                return coordinator_checkpoint(self.map.id)
            case "traffic":
                return traffic_checkpoint(self.map.id)
            case _:
                return ""

    @property
    def group(self) -> str:
        """Name of its container group."""
        default = self.serves if self.maps else f"{self.map.id}@{self.map.version}"
        return self.container_group or default

    @property
    def maps(self) -> bool:
        """True if its robot makes a new map. Such a container has no layers and stores no plans.

        It shares positions with robots on the published map that it continues (`RobotConfig.continued`), or else with
        those that make a map of the same name, once their maps are joined.
        """
        return self.robot is not None and self.robot.new_map != ""

    @property
    def joint_map(self) -> str:
        """Name of the joint map that the new map of its robot may become part of; empty if there is none."""
        robot = self.robot
        if robot is None or not self.maps or robot.continued is not None:
            return ""
        return f"{self.map.id}@{robot.map_owner or self.user}"

    def on_maps(self, version: MapVersion, masks: dict[str, MapVersion], *, in_space: bool) -> "ContainerSpec":
        """Return the spec with other versions of its map and masks; ``in_space`` is whether the map has an octomap."""
        if self.robot is None:
            return msgspec.structs.replace(self, map=version)
        robot = msgspec.structs.replace(self.robot, masks=masks, in_space=in_space)
        return msgspec.structs.replace(self, map=version, robot=robot)

    @property
    def serves(self) -> str:
        """The user and robot that it serves, or the user whose paths it plans or whose group it serves."""
        return f"{self.user}/{self.robot.id}" if self.robot is not None else self.user


_KINDS: dict[GroupNode, ContainerKind] = {"": "planning", "people": "coordinator", "traffic": "traffic"}


class Launch(msgspec.Struct, frozen=True):
    """Arguments that a machine passes to the process of a container.

    Parameters
    ----------
    layers : str
        Folder of the map layers in shared memory; for a robot that makes a new map, of the pose graph that it
        continues, or empty.
    link : str
        Unix socket of the endpoint, for the robot link. The container is *ready* after that handshake.
    machine : str
        Unix socket of the machine, for the machine link.
    secret : str
        Secret of the container for both handshakes.
    cpus : tuple of int
        CPUs that it may run on.
    threads : int
        Most threads of its kernels.
    allowed : tuple of str
        Third-party plug-ins that may run in it, each as ``group:name`` of its entry point.
    on : str
        Name of the machine.
    compiled : bool
        Whether all kernels are compiled; if not, the container asks its machine for those that it needs.
    traces : Sampling, optional
        Which traces the container begins; None if it records no spans.
    """

    spec: ContainerSpec
    layers: str
    link: str
    machine: str
    secret: str
    cpus: tuple[int, ...]
    threads: int
    allowed: tuple[str, ...] = ()
    on: str = ""
    compiled: bool = True
    traces: Sampling | None = None


def base_frame(robot: RobotConfig | None) -> str:
    """Return the name of the frame in which a robot is driven; parameters that its container refuses do not count."""
    return BASE_LINK if robot is None else frame_names(robot).base


def frame_names(robot: RobotConfig) -> FrameNames:
    """Return the frame in which a robot is driven and its prefix; parameters that are not names do not count."""
    node, name = ("grid_slam", "base_frame") if robot.new_map else ("amcl", "base_frame_id")
    table = robot.parameters.get(node)
    given = table if isinstance(table, dict) else {}
    frame, prefix = given.get(name, BASE_LINK), given.get("tf_prefix", "")
    if not (isinstance(frame, str) and isinstance(prefix, str)):
        return FrameNames()
    return FrameNames.of("", frame, "", prefix)
