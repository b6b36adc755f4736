"""Last refusals of robots that tried to connect."""

import pytest

from endpoints.services.refused_connects import MOST_ROBOTS, RefusedConnect, RefusedConnects
from ppaas.clock import ManualClock
from ppaas.errors import Conflict


def refuse(refused: RefusedConnects, robot: str, role: str = "robot") -> None:
    with pytest.raises(Conflict), refused.attempt("ann", robot, role):
        raise Conflict("it is connected already")


def test_refusal_is_kept_with_its_age_until_the_robot_connects() -> None:
    clock = ManualClock()
    refused = RefusedConnects(clock)
    refuse(refused, "tb1")
    clock.advance(7.0)
    assert refused.last("ann", "tb1") == RefusedConnect("conflict: it is connected already", 7.0)
    assert refused.last("bob", "tb1") is None
    with refused.attempt("ann", "tb1", "robot"):
        pass
    assert refused.last("ann", "tb1") is None


def test_operators_do_not_count() -> None:
    refused = RefusedConnects()
    refuse(refused, "tb1", "operator")
    assert refused.last("ann", "tb1") is None
    refuse(refused, "tb1")
    with refused.attempt("ann", "tb1", "operator"):
        pass
    assert refused.last("ann", "tb1") is not None


def test_number_of_robots_is_bounded() -> None:
    refused = RefusedConnects()
    for number in range(MOST_ROBOTS + 1):
        refuse(refused, f"tb{number}")
    assert refused.last("ann", "tb0") is None
    assert refused.last("ann", f"tb{MOST_ROBOTS}") is not None
