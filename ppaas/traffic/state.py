"""State of the traffic, for those who look at it."""

from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.fleet.traffic import MapPoint, TrafficRobot, TrafficState
from ppaas.traffic.coordinator import Coordinator
from ppaas.traffic.members import Member


def state_of(coordinator: Coordinator, stamp: float, now: float, seconds: float) -> TrafficState:
    """Return the traffic as it is.

    Parameters
    ----------
    coordinator : Coordinator
    stamp : float
        Time since 1970, for the header [s].
    now : float
        Time by the clock of the coordinator [s].
    seconds : float
        Time that it has planned and granted for so far [s].
    """
    robots = [_robot(coordinator, member, now) for _, member in sorted(coordinator.members.items())]
    header = Header(stamp=Time.of(stamp), frame_id="map")
    return TrafficState(header, coordinator.epoch, coordinator.spacing, robots, coordinator.occupancy.goals, seconds)


def _robot(coordinator: Coordinator, member: Member, now: float) -> TrafficRobot:
    report = member.report
    way = [MapPoint(*coordinator.occupancy.cells.centre(cell)) for cell in [*sorted(member.base), *member.chain]]
    waited = now - member.waits_since if member.waits_for else 0.0
    state, why = _state(member), member.waits_for
    if none := coordinator.without_cells(member):
        state, why, waited = "no_cells", none, 0.0
    return TrafficRobot(
        member.name, state, report.x, report.y, report.theta, way, why, report.goal_id, report.goal, waited
    )


def _state(member: Member) -> str:
    if member.standing != "joined":
        return member.standing
    if member.report.free:
        return "free"
    if member.waits_for:
        return "waiting"
    return "driving" if member.ahead or member.report.goal_id else "idle"
