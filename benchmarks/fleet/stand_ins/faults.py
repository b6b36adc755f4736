"""Faults of stand-ins and of the traffic node, and how long it takes until things go on."""

import math

from benchmarks.fleet.stand_ins.robot import StandIn
from benchmarks.fleet.stand_ins.simulation import Simulation

PUSH = 0.45
"""Distance by which a robot is pushed off its way, as a part of the distance between two cells."""

AWAY = 5.0
"""Time for which there is no traffic node [s]."""

MOST = 120.0
"""Longest time for which things are waited for [s]."""


def break_one(simulation: Simulation) -> None:
    """Stop a robot that drives, for ever."""
    simulation.rng.choice([robot for robot in simulation.robots if robot.way.ahead]).dead = True


def push_one(simulation: Simulation) -> float:
    """Push a robot off its way, where there is room; return the time until it has reached another cell [s]."""
    while (pushed := _push(simulation)) is None:
        simulation.step(again=True)
    began, revision = simulation.now, pushed.way.revision
    while (pushed.way.revision == revision or not pushed.way.reached) and simulation.now < began + MOST:
        simulation.step(again=True)
    return round(simulation.now - began, 1)


def restart_node(simulation: Simulation) -> float:
    """Let the traffic node die, and another one begin, which knows nothing; return its time until it grants [s]."""
    simulation.kill_node()
    simulation.run(AWAY, again=True)
    simulation.start_node()
    began, ends = simulation.now, [(robot.way.revision, robot.way.end) for robot in simulation.robots]
    while simulation.now < began + MOST:
        simulation.step(again=True)
        now = [(robot.way.revision, robot.way.end) for robot in simulation.robots]
        if any(one[0] == other[0] and one[1] > other[1] for one, other in zip(now, ends, strict=True)):
            break
    return round(simulation.now - began, 1)


def _push(simulation: Simulation) -> StandIn | None:
    """Push a robot to where it touches no cell of others, if there is one."""
    reach = PUSH * simulation.hall.spacing
    for robot in simulation.robots:
        for quarter in range(4) if robot.way.ahead and not robot.dead else ():
            angle = quarter * math.pi / 2.0
            x, y = robot.pose.x + reach * math.cos(angle), robot.pose.y + reach * math.sin(angle)
            pose = robot.pose._replace(x=x, y=y)
            if _holders(simulation, x, y, robot.radius) <= {robot.name} and robot.way.is_stray(pose):
                robot.pose = pose
                return robot
    return None


def _holders(simulation: Simulation, x: float, y: float, radius: float) -> set[str]:
    """Return who holds the cells that a disc touches."""
    coordinator = simulation.coordinator
    assert coordinator is not None, "there is a traffic node"
    cells = simulation.hall.touched(x, y, radius).tolist()
    return {name for cell in cells for name in coordinator.occupancy.holders[cell]}
