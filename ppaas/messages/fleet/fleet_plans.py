"""Types of ``ppaas_msgs`` for plans of fleets."""

from msgspec import field

from ppaas.messages.base.message import Message, OwnMessage, ServiceType

PACKAGE = "ppaas_msgs"
"""ROS package of these types."""


class ComputeFleetPlanRequest(Message):
    """``ppaas_msgs/ComputeFleetPlan`` request.

    Parameters
    ----------
    starts, goals : list of float
        x, y of each robot, one after the other, in the frame of the map [m].
    radius, margin : float
        Radius of the robots, and the distance by which they may stray from their paths [m].
    speed : float
        Speed of the robots [m/s]: each step takes as long as they need from one cell to the next.
    seconds : float
        Time in which the first plan is improved [s].
    seed : int
        Seed of the random numbers.
    timeout : float
        Time limit for the whole request [s]; it ends the improvement, too.
    turn_seconds : float
        Time of a quarter turn [s].
    speeds : list of float
        Speed of each robot [m/s], instead of ``speed``; empty without.
    """

    starts: list[float]
    goals: list[float]
    radius: float
    margin: float = 0.05
    speed: float = 0.5
    seconds: float = 0.0
    seed: int = 0
    timeout: float = 10.0
    turn_seconds: float = 0.0
    speeds: list[float] = field(default_factory=list)


class ComputeFleetPlanResponse(OwnMessage):
    """``ppaas_msgs/ComputeFleetPlan`` response.

    Parameters
    ----------
    paths : str
        JSON: a list for each robot with the x, y [m] of a cell's centre at each step, in the frame of the map.
    times : str
        JSON: a list for each robot with the time at which it reaches each of these [s], if all keep the order of the
        plan.
    spacing : float
        Distance of the centres of neighbouring cells [m].
    step_seconds : float
        Duration of a step of the slowest robot [s].
    cost : int
        Sum of the last arrivals of all robots at their goals [steps].
    bound : int
        Sum of the lengths of shortest paths, below which no cost is [steps].
    makespan : int
        Last arrival of all [steps].
    turns : int
        Number of quarter turns of all robots.
    seconds : float
        Computing time [s].
    """

    paths: str
    times: str
    spacing: float
    step_seconds: float
    cost: int
    bound: int
    makespan: int
    turns: int
    seconds: float


ComputeFleetPlan = ServiceType("ppaas_msgs/ComputeFleetPlan", ComputeFleetPlanRequest, ComputeFleetPlanResponse)

SERVICES = (ComputeFleetPlan,)
