"""What a run of simulated robots gave, as one JSON object."""

import math

import msgspec


class RobotReport(msgspec.Struct):
    """One robot.

    Parameters
    ----------
    id : str
        Its name.
    goals_asked, goals_reached : int
        A goal counts as reached when Move Base says so.
    distance_m : float
        Truly travelled [m].
    final_errors_m : list of float
        True distance from each goal at the moment when its result came [m].
    collisions : int
        Touches of walls and other robots.
    plan_seconds : list of float or None
        From each goal sent to the first plan received; None where none came.
    ready_seconds : float or None
        From the beginning of the robot's WebSocket to the first pose that localization gave its operator.
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
        """Note what became of a goal."""
        self.goals_reached += reached
        self.final_errors_m.append(round(error, 4))
        self.plan_seconds.append(round(plan_seconds, 4) if math.isfinite(plan_seconds) else None)


class DemoReport(msgspec.Struct):
    """A whole run: the map, how long the robots were under way [s], and each of them."""

    map: str
    seconds: float
    robots: list[RobotReport]

    @property
    def passed(self) -> bool:
        """Tell whether every goal was reached and nothing was touched."""
        return all(robot.goals_reached == robot.goals_asked and not robot.collisions for robot in self.robots)

    def to_json(self) -> str:
        """Return it on one line."""
        return msgspec.json.encode(self).decode()
