"""State of a coordinator as a message."""

from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import Point
from ppaas.messages.people_coordination import LOST, FollowOrder, GroupRobot, PeopleState, TrackedPerson
from ppaas.people.coordinator.identities import people_counter
from ppaas.people.coordinator.parts import CoordinatorParts

MAP = "map"

SHOWN = 10.0
"""Time for which people are in the message after they were seen last, unless they are followed [s]."""


def state_of(coordinator: CoordinatorParts, now: float) -> PeopleState:
    """Return the state of a coordinator at a time [s since the epoch]."""
    counted = [person.id for person in coordinator.table.rows if person.counts for _ in person.seen_by or (None,)]
    return PeopleState(
        header=Header(stamp=Time.of(now), frame_id=MAP),
        count=people_counter(counted),
        people=_people(coordinator, now),
        orders=[
            FollowOrder(order.robot, person, order.cost, Time.of(order.since), order.reason)
            for person, order in sorted(coordinator.follow.orders.items())
        ],
        robots=_robots(coordinator, now),
        rule=coordinator.settings.rule,
    )


def _people(coordinator: CoordinatorParts, now: float) -> list[TrackedPerson]:
    table, names = coordinator.table, coordinator.settings.names
    followed = coordinator.follow.orders
    people = []
    rows = zip(
        table.rows, table.positions.tolist(), table.velocities.tolist(), table.covariances.reshape(-1, 4).tolist(),
        strict=True,
    )  # fmt: skip
    for person, (x, y), (vx, vy), covariance in rows:
        shown = person.counts or person.id in followed or now - person.last_seen <= SHOWN
        if not (person.confirmed and shown and (person.counts or person.state != "seen")):
            continue
        people.append(
            TrackedPerson(
                person.id,
                Point(x, y),
                Point(0.0, 0.0) if person.state == LOST else Point(vx, vy),
                covariance,
                names.get(str(person.id), ""),
                person.state,
                list(person.seen_by.values()),
                Time.of(person.first_seen),
                Time.of(person.last_seen),
                person.group,
            )
        )
    return people


def _robots(coordinator: CoordinatorParts, now: float) -> list[GroupRobot]:
    robots = []
    for name, robot in sorted(coordinator.robots.known.items()):
        reason = robot.reason(now, 3.0 * coordinator.parameters.report_timeout)
        pose = robot.pose
        where, deviation = Point(float(pose.x), float(pose.y)), float(robot.deviation)
        robots.append(GroupRobot(name, where, deviation, len(robot.report.ids), not reason, reason))
    return robots
