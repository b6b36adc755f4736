"""JSON schemas of the traffic of robots on a map."""

from pydantic import Field

from endpoints.rest.schemas import ResponseBody
from ppaas.messages.fleet.traffic import MapPoint, TrafficRobot, TrafficState

Point = tuple[float, float]


class TrafficRobotAnswer(ResponseBody):
    """Robot that takes part in the traffic of a map."""

    robot: str
    state: str = Field(
        description="`driving`, `waiting`, `idle`, `free`, `stopped`, `stray`, `silent`, `no_cells` or `out`"
    )
    pose: tuple[float, float, float] = Field(description="x, y [m], yaw [rad]")
    way: list[Point] = Field(description="Cells that it holds, x, y [m], in the order in which it passes them")
    waits_for: str = Field(description="Why it waits or has no cells; empty if it does not")
    goal_id: str = Field(description="Goal that it drives to; empty if it has none")
    goal: Point | None = Field(description="x, y [m]; null if it has none")
    waited: float = Field(description="Time for which it has waited [s]")

    @classmethod
    def of(cls, robot: TrafficRobot) -> "TrafficRobotAnswer":
        """Return a robot as JSON."""
        return cls(
            robot=robot.robot,
            state=robot.state,
            pose=(robot.x, robot.y, robot.theta),
            way=[_point(point) for point in robot.way],
            waits_for=robot.waits_for,
            goal_id=robot.goal_id,
            goal=_point(robot.goal) if robot.goal_id else None,
            waited=robot.waited,
        )


class TrafficAnswer(ResponseBody):
    """Traffic of the caller's robots on a map."""

    map: str
    at: float = Field(description="Time of the positions [s since the epoch]")
    spacing: float = Field(description="Distance of neighbouring cells [m]; 0 before there is a robot")
    robots: list[TrafficRobotAnswer]
    goals: int = Field(description="Number of goals that robots have reached since the traffic node began")
    seconds: float = Field(description="Time for which the traffic node has planned since then [s]")

    @classmethod
    def of(cls, map_id: str, state: TrafficState) -> "TrafficAnswer":
        """Return the traffic of a map as JSON."""
        return cls(
            map=map_id,
            at=state.header.stamp.seconds(),
            spacing=state.spacing,
            robots=[TrafficRobotAnswer.of(robot) for robot in state.robots],
            goals=state.goals,
            seconds=state.seconds,
        )


def _point(point: MapPoint) -> Point:
    return point.x, point.y
