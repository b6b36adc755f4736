"""Report of a demo, as one JSON object and as lines."""

import math
from typing import Protocol

import msgspec


class AnyReport(Protocol):
    """Report of any demo."""

    @property
    def passed(self) -> bool:
        """Whether the demo showed what it is for."""
        ...

    def to_json(self) -> str:
        """Return the report as one line of JSON."""
        ...

    def lines(self) -> list[str]:
        """Return the report for people."""
        ...


class RobotReport(msgspec.Struct):
    """Report of one robot.

    Parameters
    ----------
    id : str
        Id of the robot.
    goals_asked, goals_reached : int
        Number of goals sent, and of goals that Move Base reported as reached.
    distance_m : float
        True distance travelled [m].
    final_errors_m : list of float
        True distance to each goal when its result arrived [m].
    collisions : int
        Contacts with walls, robots and people.
    plan_seconds : list of float or None
        Time from sending each goal to the first plan [s]; None if there was no plan.
    ready_seconds : float or None
        Time from opening the WebSocket to the first pose estimate [s].
    """

    id: str
    goals_asked: int = 0
    goals_reached: int = 0
    distance_m: float = 0.0
    final_errors_m: list[float] = []
    collisions: int = 0
    plan_seconds: list[float | None] = []
    ready_seconds: float | None = None

    def add_goal(self, reached: bool, error: float, plan_seconds: float) -> None:
        """Add the outcome of a goal."""
        self.goals_reached += reached
        self.final_errors_m.append(round(error, 4))
        self.plan_seconds.append(round(plan_seconds, 4) if math.isfinite(plan_seconds) else None)

    def line(self) -> str:
        """Return the report for people."""
        worst = f", at most {max(self.final_errors_m):.2f} m off" if self.final_errors_m else ""
        goals = f"{self.goals_reached} of {self.goals_asked} goals reached{worst}, " if self.goals_asked else ""
        return f"{self.id}: {goals}{self.distance_m:.1f} m travelled, {self.collisions} contacts"


class DemoReport(msgspec.Struct):
    """Report of a demo: the map, the driving time [s], and a report per robot."""

    map: str
    seconds: float
    robots: list[RobotReport]

    @property
    def passed(self) -> bool:
        """Whether every goal was reached without a contact."""
        return all(robot.goals_reached == robot.goals_asked and not robot.collisions for robot in self.robots)

    def to_json(self) -> str:
        """Return the report as one line of JSON."""
        return msgspec.json.encode(self).decode()

    def lines(self) -> list[str]:
        """Return a line for each robot, and one about all."""
        return [*(robot.line() for robot in self.robots), outcome(self)]


class ExplorationReport(msgspec.Struct):
    """Report of a demo in which robots explore, and another drives on the map that the first one has published.

    Parameters
    ----------
    map : str
        Id of the published map.
    seconds : float
        Duration of exploring and driving [s].
    explored : str
        How the exploration of the first robot ended that did not succeed; else ``succeeded``.
    explored_seconds : float
        Duration of the longest exploration [s].
    frontiers, unreachable : int
        Frontiers left, and those that a robot gave up.
    area_m2 : float
        Known area of the published map [m²].
    known_cells, wrong_cells : int
        Known cells of the published map, and those of them that are wrong.
    robots : list of RobotReport
        The robots that explored, and the one that drove on their map.
    joined_seconds : float, optional
        Time after which the maps of all robots that explored were one [s]; None if they never were, or for one robot.
    """

    map: str
    seconds: float
    explored: str
    explored_seconds: float
    frontiers: int
    unreachable: int
    area_m2: float
    known_cells: int
    wrong_cells: int
    robots: list[RobotReport]
    joined_seconds: float | None = None

    @property
    def passed(self) -> bool:
        """Whether all was explored, at most 1 % of the cells are wrong, and all goals were reached without contact."""
        drove = all(robot.goals_reached == robot.goals_asked and not robot.collisions for robot in self.robots)
        return self.explored == "succeeded" and 100 * self.wrong_cells <= self.known_cells and drove

    def to_json(self) -> str:
        """Return the report as one line of JSON."""
        return msgspec.json.encode(self).decode()

    def lines(self) -> list[str]:
        """Return lines about the exploration and its map, one for each robot, and one about all."""
        joined = [] if self.joined_seconds is None else [f"the maps were joined after {self.joined_seconds:.0f} s"]
        share = 100.0 * self.wrong_cells / max(self.known_cells, 1)
        return [
            *joined,
            f"exploring {self.explored} after {self.explored_seconds:.0f} s: {self.frontiers} frontiers left, "
            f"{self.unreachable} given up",
            f"map: {self.area_m2:.1f} m² known, {self.wrong_cells} of {self.known_cells} cells wrong ({share:.2f} %)",
            *(robot.line() for robot in self.robots),
            outcome(self),
        ]


class BuildingReport(DemoReport):
    """Report of a demo in which robots are sent between the floors of a building.

    Parameters
    ----------
    rides : int
        Rides of robots in lifts.
    lift_wait_mean_s, lift_wait_max_s : float
        Time from the arrival of a robot before a lift until it was in the car [s]; 0 without a ride.
    ride_mean_s : float
        Time in the car [s]; 0 without a ride.
    """

    rides: int = 0
    lift_wait_mean_s: float = 0.0
    lift_wait_max_s: float = 0.0
    ride_mean_s: float = 0.0

    def lines(self) -> list[str]:
        """Return a line for each robot, one about the lifts, and one about all."""
        *robots, last = super().lines()
        lifts = (
            f"{self.rides} rides in lifts: {self.lift_wait_mean_s:.0f} s of waiting in the mean, at most "
            f"{self.lift_wait_max_s:.0f} s; {self.ride_mean_s:.0f} s in the car"
        )
        return [*robots, lifts, last]


def outcome(report: DemoReport | ExplorationReport) -> str:
    """Return the last line of a report."""
    return f"{'passed' if report.passed else 'failed'} in {report.seconds:.0f} s on map {report.map!r}"
