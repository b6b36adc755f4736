"""Measurement of many stand-ins in a hall: contacts, deadlocks, goals beside robots alone, faults and their cost."""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from benchmarks.fleet.stand_ins.hall import Hall
from benchmarks.fleet.stand_ins.robot import StandIn
from benchmarks.fleet.stand_ins.simulation import Simulation
from benchmarks.harness.figures import Figure
from benchmarks.harness.halls import distance_figure
from ppaas.errors import InvalidInput

PART = "stand-ins"

WARM_UP = 180.0
"""Time before goals count [s]: at first robots are spread evenly, and near goals are reached first."""

AFTERWARDS = 60.0
"""Time for which robots drive on after a short fault [s]."""

LATE, LOSS = 2.0, 0.1
"""Largest delay of messages [s], and part that are lost, in the run with a bad network."""

BROKEN_SHARE = 0.85
"""Least part of the goals that are still reached after a robot has stopped for ever."""

GRANTS_AGAIN = 2.0
"""Longest time until the next traffic node grants [s]."""

Tell = Callable[[str, float], None]
"""Called with what is being run, and the simulated time since the last call [s]."""


@dataclass(frozen=True, slots=True)
class StandInCase:
    """Stand-ins in a hall for some time.

    Parameters
    ----------
    hall : Hall
    seconds : float
        Simulated time of each run [s].
    """

    hall: Hall
    seconds: float

    @property
    def name(self) -> str:
        """Name of its figures."""
        return f"{self.hall.name}, {self.hall.robots}, seed {self.hall.seed}"

    @property
    def total(self) -> float:
        """Simulated time of all runs but those of robots that are alone, about [s]."""
        return 2.0 * WARM_UP + 3.0 * self.seconds + 2.0 * AFTERWARDS + AWAY


def case_of(words: Sequence[str]) -> StandInCase:
    """Return the case of the words on a command line: hall, robots, minutes, seed.

    Raises
    ------
    InvalidInput
        There is no such hall, no room for the robots, or a number is not one.
    """
    hall, robots, minutes, seed = words
    try:
        numbers = int(robots), int(seed), 60.0 * float(minutes)
    except ValueError as error:
        raise InvalidInput(f"robots, minutes and seed must be numbers: {error}") from error
    if not numbers[2] > 0.0:
        raise InvalidInput(f"the time must be more than 0 minutes, not {minutes}")
    return StandInCase(Hall(hall, *numbers[:2]), numbers[2])


def measure(case: StandInCase, tell: Tell) -> Iterator[Figure]:
    """Run robots without faults, then with one fault after the other, then in a bad network."""
    tell(f"{case.name}: robots that are alone", 0.0)
    alone = case.hall.goals_alone() * case.seconds * case.hall.robots
    simulation = case.hall.simulation(case.hall.robots, case.hall.seed)
    before = _goals(case, simulation, "all is well", tell)
    yield from _ordinary(case, simulation, before, alone)
    yield from _after_faults(case, simulation, before, tell)
    yield from _safety(case, simulation, "")
    bad = case.hall.simulation(case.hall.robots, case.hall.seed, LATE, LOSS)
    goals = _goals(case, bad, "messages are late and lost", tell)
    network = f", messages up to {LATE:g} s late and {LOSS:.0%} lost"
    yield Figure(PART, f"{case.name}{network}: goals", goals, "", note=f"{goals / alone:.0%} of robots alone")
    yield from _safety(case, bad, network)


def _goals(case: StandInCase, simulation: Simulation, what: str, tell: Tell) -> int:
    """Let robots drive; return the number of goals reached after the begin."""
    _run(simulation, WARM_UP, f"{case.name}: {what}", tell)
    before = simulation.arrived
    _run(simulation, case.seconds, f"{case.name}: {what}", tell)
    return simulation.arrived - before


def _run(simulation: Simulation, seconds: float, what: str, tell: Tell) -> None:
    end = simulation.now + seconds
    while simulation.now < end:
        began = simulation.now
        simulation.run(1.0, again=True)
        tell(what, simulation.now - began)


def _ordinary(case: StandInCase, simulation: Simulation, goals: int, alone: float) -> Iterator[Figure]:
    times = [seconds for robot in simulation.robots for seconds in robot.times]
    spent = 1e3 * np.array(simulation.spent)
    yield Figure(
        PART, f"{case.name}: goals", goals, "",
        note=f"in {case.seconds / 60.0:g} min; {goals / alone:.0%} of robots that are each alone",
    )  # fmt: skip
    mean = np.mean(times) if times else 0.0
    yield Figure(
        PART, f"{case.name}: longest open goal", round(simulation.longest, 1), "s",
        note=f"mean of those reached {mean:.1f} s",
    )  # fmt: skip
    if simulation.misses:
        yield distance_figure(PART, case.name, simulation.misses)
    yield Figure(
        PART, f"{case.name}: a step of the coordinator", round(float(np.median(spent)), 2), "ms",
        note=f"CPU time, reports included; 99 % of steps within {np.percentile(spent, 99.0):.2f} ms",
    )  # fmt: skip


def _after_faults(case: StandInCase, simulation: Simulation, before: int, tell: Tell) -> Iterator[Figure]:
    break_one(simulation)
    reached = simulation.arrived
    _run(simulation, case.seconds, f"{case.name}: a robot has stopped for ever", tell)
    share = (simulation.arrived - reached) / max(before, 1)
    yield Figure(
        PART, f"{case.name}: goals after a robot stopped for ever", round(share, 3), "", limit=BROKEN_SHARE, floor=True,
        note="beside those in the same time before",
    )  # fmt: skip
    back = push_one(simulation)
    yield Figure(PART, f"{case.name}: a stray is led back", back, "s", limit=MOST, note="until it reached another cell")
    _run(simulation, AFTERWARDS, f"{case.name}: a robot was pushed off its way", tell)
    again = restart_node(simulation)
    yield Figure(
        PART, f"{case.name}: the next traffic node grants", again, "s", limit=GRANTS_AGAIN,
        note=f"after its begin; there was none for {AWAY:g} s",
    )  # fmt: skip
    _run(simulation, AFTERWARDS, f"{case.name}: the traffic node was killed", tell)


def _safety(case: StandInCase, simulation: Simulation, run: str) -> Iterator[Figure]:
    contacts, minutes = simulation.contacts, simulation.now / 60.0
    yield Figure(
        PART, f"{case.name}{run}: contacts", contacts.count, "", limit=0.0,
        note=f"in all {minutes:.0f} min; nearest {contacts.nearest:.3f} m",
    )  # fmt: skip
    yield Figure(
        PART, f"{case.name}{run}: deadlocks", simulation.deadlocks, "", limit=0.0,
        note=f"nobody got on for at most {simulation.stood:.1f} s",
    )  # fmt: skip


# -- faults of stand-ins and of the traffic node, and how long it takes until things go on -----------------------------

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
