"""Views of machines and containers that the engine returns to the endpoints."""

from typing import Literal

import msgspec

from engine.protocols.versions import UNSTATED
from engine.specs.containers import ContainerKind, MapVersion
from engine.specs.cores import OVERSUBSCRIPTION
from engine.specs.goal_states import GoalState
from engine.specs.machine_settings import MAX_CONTAINERS
from engine.specs.robot_report import StateReport
from engine.specs.start_state import KernelProgress

ContainerState = Literal["starting", "ready"]
MachineState = Literal["starting", "ready", "draining", "drained"]
EndpointViewState = Literal["ready", "silent"]


class MachineView(msgspec.Struct, frozen=True):
    """State of a machine.

    Parameters
    ----------
    cores : int
        Number of CPUs.
    capacity : float
        Total size that it may give to containers [cores], by its CPUs, oversubscription and memory.
    containers : int
        Number of containers placed on it.
    memory, memory_used : int
        Total memory and memory in use [bytes].
    load : float
        CPU in use [cores].
    given : float
        Sum of the sizes of its containers [cores].
    memory_given : int
        Memory that these sizes count for [bytes].
    state : {"starting", "ready", "draining", "drained"}
        ``starting`` if it has not joined yet, and only its name is known; ``ready`` if it accepts containers;
        ``draining`` while its containers move to others, ``drained`` afterwards.
    labels : dict of str to str
        Labels of its agent and of the administrator.
    max_containers : int
        Largest number of containers.
    max_memory : int, optional
        Upper limit of the memory that it may give [bytes]; None for all of its memory.
    oversubscription : float
        Factor by which the cores that it gives exceed the cores that it has.
    draining : bool
        Whether an administrator is draining it.
    network : float, optional
        Capacity of its network, sent and received [bytes/s]; None if unknown.
    network_used : float
        Data sent and received [bytes/s].
    round_trip : float
        Average round trip to the robots that it serves and to other machines [s].
    round_trips : dict of str to float
        Round trips to other machines, by name [s].
    kernels : KernelProgress, optional
        Progress of its kernel compiler; None if all kernels are compiled, or it is not known yet.
    release : str
        Release of its software; empty if it has not joined yet.
    protocol : int
        Protocol version of its link to the master; 0 if it has not joined yet.
    """

    id: str
    cores: int
    capacity: float
    containers: int
    memory: int
    memory_used: int
    load: float
    given: float = 0.0
    memory_given: int = 0
    state: MachineState = "ready"
    labels: dict[str, str] = {}
    max_containers: int = MAX_CONTAINERS
    max_memory: int | None = None
    oversubscription: float = OVERSUBSCRIPTION
    draining: bool = False
    network: float | None = None
    network_used: float = 0.0
    round_trip: float = 0.0
    round_trips: dict[str, float] = {}
    kernels: KernelProgress | None = None
    release: str = ""
    protocol: int = 0


class EndpointView(msgspec.Struct, frozen=True):
    """State of an endpoint.

    Parameters
    ----------
    id : str
        Name of the endpoint.
    machine : str
        Machine on which it runs.
    pid : int
        Process id there.
    url : str
        Address at which clients reach it.
    release : str
        Release of its software.
    sockets : int
        Number of sockets of robots and operators.
    frames : float
        Frames that clients sent [1/s].
    cpu : float
        CPU in use [cores].
    memory : int
        Memory in use [bytes].
    state : {"ready", "silent"}
        ``silent`` if it is connected, but has not reported its load for a while.
    protocol : int
        Protocol version of its link to the master.
    """

    id: str
    machine: str
    pid: int
    url: str
    release: str
    sockets: int
    frames: float
    cpu: float
    memory: int
    state: EndpointViewState
    protocol: int = UNSTATED.newest


class ContainerView(msgspec.Struct, frozen=True):
    """State of a container.

    Parameters
    ----------
    robot : str, optional
        Robot of the clone; None for a planning container or the node of a group.
    cores : float
        Size of the container [cores].
    pid : int, optional
        Process id, once it runs.
    pss : int, optional
        Proportional set size [bytes], once it was measured.
    ready_seconds : float, optional
        Time from the order to its machine until it answered [s].
    cpu : float, optional
        CPU in use [cores], once it was measured.
    age : float
        Time since the order to start it [s].
    clients : int
        Number of connected clients: the robot and its operators.
    connected : bool
        Whether the robot is connected; its container may outlive that for a while.
    round_trip : float, optional
        Round trip to the robot [s], once it was measured.
    masks : tuple of str
        Ids of the maps that its costmap filters use as masks.
    """

    id: str
    kind: ContainerKind
    user: str
    robot: str | None
    map: MapVersion
    machine: str
    cores: float
    state: ContainerState
    pid: int | None = None
    pss: int | None = None
    ready_seconds: float | None = None
    cpu: float | None = None
    age: float = 0.0
    clients: int = 0
    connected: bool = False
    round_trip: float | None = None
    masks: tuple[str, ...] = ()


class MappingRobot(msgspec.Struct, frozen=True):
    """Robot that makes its own new map.

    Parameters
    ----------
    user, robot : str
    joint_map : str
        Name of the joint map that its map may become part of.
    """

    user: str
    robot: str
    joint_map: str


class PeopleGroupView(msgspec.Struct, frozen=True):
    """Group of a user's robots on a map that track people.

    Parameters
    ----------
    user : str
    map : str
        Id of the map.
    robots : tuple of str
        The robots with a place now, sorted.
    state : {"refused", "starting", "ready"}
        State of the group's coordinator.
    reason : str
        Why the group has no coordinator, if it was refused. It is tried again.
    """

    user: str
    map: str
    robots: tuple[str, ...]
    state: Literal["refused", "starting", "ready"]
    reason: str = ""


class LifelongRobot(msgspec.Struct, frozen=True):
    """Robot that continues a published map for life.

    Parameters
    ----------
    user, robot : str
    map : str
        Id of the map.
    """

    user: str
    robot: str
    map: str


class GoalView(msgspec.Struct, frozen=True):
    """State of a goal that was sent to a robot by REST.

    Parameters
    ----------
    pose : tuple of float
        Goal pose in the frame ``map``: x [m], y [m], yaw [rad].
    state : str
        ``lost`` if the robot's clone does not know the goal any more.
    text : str
        Reason for a wait, or for the end of the goal.
    sent, ended : float
        Times [s since the epoch]; ``ended`` is None while the goal is active.
    """

    id: str
    pose: tuple[float, float, float]
    state: GoalState
    text: str
    sent: float
    ended: float | None = None


class NavigationState(msgspec.Struct, frozen=True):
    """Pose and goals of a robot.

    Parameters
    ----------
    connected : bool
        Whether the robot is connected: its own socket is at an endpoint.
    disconnected_since : float, optional
        Time at which it was lost [s since the epoch]; None while the robot is connected, or if it is not known.
    container : bool
        Whether the robot has a container, which may wait for it to come back.
    pose : tuple of float, optional
        Estimated pose in the frame ``map``: x [m], y [m], yaw [rad]; None before localization.
    pose_at : float, optional
        Time at which the pose was received [s since the epoch].
    localization : str
        Reason why the pose is not renewed, such as scans that are refused; empty if it is.
    goals : tuple of GoalView
        Goals that have not ended, oldest first.
    """

    connected: bool
    disconnected_since: float | None = None
    container: bool = False
    pose: tuple[float, float, float] | None = None
    pose_at: float | None = None
    localization: str = ""
    goals: tuple[GoalView, ...] = ()


class ReportedRobot(msgspec.Struct, frozen=True):
    """State of a robot, for lists of many robots.

    Parameters
    ----------
    connected : bool
        Whether the robot is connected: its own socket is at an endpoint.
    disconnected_since : float, optional
        Time at which it was lost [s since the epoch]; None while the robot is connected, or if it is not known.
    container : {"starting", "ready"}, optional
        State of its container; None without one.
    machine : str
        Machine of the container; empty without one.
    report : StateReport
        What the container reported last.
    """

    connected: bool
    disconnected_since: float | None = None
    container: ContainerState | None = None
    machine: str = ""
    report: StateReport = StateReport()


class UserUsage(msgspec.Struct, frozen=True):
    """Usage of a user's quotas, without storage quotas.

    Parameters
    ----------
    containers : int
        Number of containers.
    cores : float
        Sum of their sizes [cores].
    paths : int
        Number of requested paths that count now.
    """

    containers: int
    cores: float
    paths: int
