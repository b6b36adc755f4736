"""People whom robots of the fake cloud see."""

from engine.service.views import PeopleGroupView
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import Point
from ppaas.messages.people_coordination import FollowOrder, GroupRobot, PeopleState, TrackedPerson
from tests.support.endpoints.fake_cloud import FakeCloud


def person(number: int, x: float = 1.0, **fields: object) -> TrackedPerson:
    """Return a person."""
    given = {"velocity": Point(0.5, 0.0), "covariance": [0.01, 0.0, 0.0, 0.01], "seen_by": ["tb1/4"]}
    times = {"first_seen": Time(90), "last_seen": Time(100)}
    return TrackedPerson(number, Point(x, 2.0), **(given | times | fields))  # type: ignore[arg-type]


def people_state(*people: TrackedPerson) -> PeopleState:
    """Return a state in which robot tb1 follows person 1."""
    order = FollowOrder("tb1", 1, 3.5, Time(95), "nearest")
    robot = GroupRobot("tb1", Point(0.0, 2.0), 0.2, len(people))
    header = Header(stamp=Time(100, 500_000_000), frame_id="map")
    return PeopleState(header, len(people), list(people), [order], [robot], "nearest", 0.001)


def add_group(cloud: FakeCloud, user: str, map_id: str, *people: TrackedPerson) -> None:
    """Give a fake cloud a group of the robots tb1 and tb2 that see these people."""
    cloud.groups.append(PeopleGroupView(user, map_id, ("tb1", "tb2"), "ready"))
    cloud.people_states[user, map_id] = people_state(*people)
