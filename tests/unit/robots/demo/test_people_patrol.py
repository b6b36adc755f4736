import pytest

from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import Point
from ppaas.messages.people_coordination import FollowOrder, PeopleState, TrackedPerson
from robots.demo.people_patrol import is_wanted


def person(*seen_by: str) -> TrackedPerson:
    return TrackedPerson(1, Point(0.0, 0.0), Point(0.0, 0.0), [0.01, 0.0, 0.0, 0.01], seen_by=list(seen_by))


@pytest.mark.parametrize(
    ("seen_by", "ordered", "wanted"),
    [((), "", False), (("tb1/4",), "", True), (("tb12/4",), "", False), ((), "tb1", True), ((), "tb2", False)],
)
def test_a_robot_that_sees_or_follows_somebody_does_not_patrol(
    seen_by: tuple[str, ...], ordered: str, wanted: bool
) -> None:
    orders = [FollowOrder(ordered, 1, 2.0, Time())] if ordered else []
    state = PeopleState(Header(), 1, [person(*seen_by)], orders)
    assert is_wanted("tb1", state) == wanted
