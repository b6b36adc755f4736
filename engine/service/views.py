"""What the engine tells the endpoints: machines and containers to look at, and paths that were asked for."""

from typing import Literal

import msgspec

from engine.specs.containers import ContainerKind, MapVersion
from engine.specs.cores import OVERSUBSCRIPTION
from engine.specs.machine_settings import MAX_CONTAINERS
from ppaas.plans.stored import Origin

ContainerState = Literal["starting", "ready"]
MachineState = Literal["ready", "draining", "drained"]


class MachineView(msgspec.Struct, frozen=True):
    """A machine.

    Parameters
    ----------
    cores : int
        CPUs it has.
    capacity : float
        Size it may give to containers, in cores: by its CPUs, the oversubscription and its memory.
    containers : int
        How many are placed on it.
    memory, memory_used : int
        Bytes.
    load : float
        CPU in use, in cores.
    given : float
        Sum of the sizes of its containers, in cores.
    memory_given : int
        Bytes that these count for.
    state : {"ready", "draining", "drained"}
        Whether it is given containers, or its own are moved to others, or that is done.
    labels : dict of str to str
        What it is like.
    max_containers : int
        Upper limit of containers.
    max_memory : int, optional
        Upper limit of the bytes that it may give; without it, what it has.
    oversubscription : float
        Cores that it gives away for each that it has.
    draining : bool
        Whether an administrator drains it.
    network : float, optional
        What it can send and receive in a second [bytes], where that is known.
    network_used : float
        What it sends and receives in a second [bytes].
    round_trip : float
        To the robots that it serves and to other machines, on average [s].
    round_trips : dict of str to float
        To other machines, by their names [s].
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


class ContainerView(msgspec.Struct, frozen=True):
    """A container.

    Parameters
    ----------
    robot : str, optional
        The robot whose clone runs in it; without one it only plans.
    cores : float
        Its size.
    pid : int, optional
        Of its process, once it runs.
    pss : int, optional
        Proportional set size [bytes], once it was measured.
    ready_seconds : float, optional
        From the order to start it until it answered [s].
    cpu : float, optional
        CPU in use, in cores, once it was measured.
    age : float
        Since the order to start it [s].
    clients : int
        Sockets of the robot and its operators.
    round_trip : float, optional
        To the robot, once it was measured [s].
    masks : tuple of str
        Ids of the maps that its costmap filters go by.
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
    round_trip: float | None = None
    masks: tuple[str, ...] = ()


class PathRequest(msgspec.Struct, frozen=True):
    """A path that a program asks for.

    Parameters
    ----------
    start, goal : tuple of float
        x, y [m], yaw [rad] in the frame of the map.
    tolerance : float
        If the goal is blocked, the free cell nearest to it within this distance will do [m].
    timeout : float
        Time allowed to the planner [s].
    reuse : bool
        Whether a plan that is kept will do where it comes sooner than one that is computed.
    labels : dict of str to str
        The machine that computes it has all of these.
    queue : bool
        Whether it may wait for its turn where there is no container for it now.
    """

    start: tuple[float, float, float]
    goal: tuple[float, float, float]
    planner: str = "dijkstra"
    tolerance: float = 0.0
    timeout: float = 10.0
    reuse: bool = True
    labels: dict[str, str] = {}
    queue: bool = False


class CostRequest(msgspec.Struct, frozen=True):
    """What it costs from each start to each goal, asked for by a program.

    Parameters
    ----------
    starts, goals : tuple of tuple of float
        x, y [m], yaw [rad] in the frame of the map.
    timeout : float
        Time allowed to all of it [s].
    labels : dict of str to str
        The machine that computes them has all of these.
    """

    starts: tuple[tuple[float, float, float], ...]
    goals: tuple[tuple[float, float, float], ...]
    timeout: float = 10.0
    labels: dict[str, str] = {}


class CostAnswer(msgspec.Struct, frozen=True):
    """Costs, and where they were found.

    Parameters
    ----------
    costs : str
        JSON: a row for each start, a number in it for each goal or null, as the container wrote it.
    seconds : float
        Time it took.
    container : str
        Id of the container that found them.
    pid : int
        Of its process.
    """

    costs: str
    seconds: float
    container: str
    pid: int


class PathAnswer(msgspec.Struct, frozen=True):
    """A path, and where it was found.

    Parameters
    ----------
    poses : str
        JSON: a list of rows x, y, z, qx, qy, qz, qw, as the container wrote it.
    length : float
        Along the poses [m].
    cost : float
        Sum of the weights of the moves.
    expanded : int
        Cells whose value was settled.
    seconds : float
        Time the planner took.
    planner : str
        Who planned it.
    plan_id : str
        Of the same plan the same.
    origin : str
        Whether it was computed, reused or stitched.
    reused : str
        Id of the kept plan it was made of; empty if it was computed.
    conditions : str
        Under which it was made, as JSON.
    container : str
        Id of the container that planned it.
    pid : int
        Of its process.
    """

    poses: str
    cost: float
    length: float
    expanded: int
    seconds: float
    planner: str
    plan_id: str
    origin: Origin
    reused: str
    conditions: str
    container: str
    pid: int
