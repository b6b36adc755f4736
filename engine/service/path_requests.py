"""Paths and costs that programs ask the engine for, and its answers."""

import msgspec

from ppaas.plans.stored import Origin


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
