"""The delay of a control loop is measured from commands and odometry, and the robot's motion predicted by it."""

import math
from random import Random

import pytest

from ppaas.controllers.base import Velocity
from ppaas.controllers.loop_delay import MOST, STEP, LoopDelay
from ppaas.controllers.motion import advance
from ppaas.geometry import Pose2D

PERIOD = 0.05
HERE = Pose2D(1.0, 2.0, 0.5)


def winding(time: float) -> Velocity:
    """Return the commands of a robot that speeds up, slows down and turns all the time."""
    return Velocity(0.3 + 0.2 * math.sin(1.7 * time), 0.8 * math.sin(2.3 * time))


def driven(
    delay: float,
    seconds: float = 10.0,
    *,
    loop: LoopDelay | None = None,
    begin: float = 100.0,
    jitter: float = 0.0,
    noise: float = 0.0,
    stamped: bool = False,
) -> LoopDelay:
    """Return a loop of this delay [s] after a drive; stamps, if any, are of a clock that is 1,000 s ahead."""
    loop, random = loop or LoopDelay(), Random(5)
    arrivals: list[tuple[float, Velocity, float]] = []
    for number in range(round(seconds / PERIOD)):
        now = begin + number * PERIOD
        loop.command(now, winding(now))
        seen = winding(now - delay) if now - delay >= begin else Velocity()
        velocity = Velocity(*(value + random.gauss(0.0, noise) for value in seen))
        last = arrivals[-1][0] if arrivals else 0.0
        late = max(now + jitter * random.random(), last)  # messages do not overtake each other
        arrivals.append((late, velocity, now + 1000.0 if stamped else 0.0))
        while arrivals and arrivals[0][0] <= now + 1e-9:
            loop.measure(*arrivals.pop(0))
    return loop


@pytest.mark.parametrize("delay", [0.0, 0.15, 0.3, 0.5, 1.0, MOST])
def test_the_delay_is_that_after_which_odometry_shows_the_commands(delay: float) -> None:
    assert driven(delay).seconds == pytest.approx(delay, abs=0.5 * STEP)


def test_noise_of_odometry_does_not_hide_the_delay() -> None:
    assert driven(0.4, noise=0.03).seconds == pytest.approx(0.4, abs=STEP)


def test_a_delay_that_changes_is_followed() -> None:
    loop = driven(0.2)
    driven(0.7, 15.0, loop=loop, begin=110.0)
    assert loop.seconds == pytest.approx(0.7, abs=STEP)


def test_jitter_of_stamped_odometry_is_removed() -> None:
    """What is left is the delay of the fastest messages."""
    assert driven(0.3, 20.0, jitter=0.2, stamped=True).seconds == pytest.approx(0.3, abs=STEP)


def test_constant_commands_say_nothing_about_the_delay() -> None:
    loop = driven(0.5)
    for number in range(100):
        now = 110.0 + number * PERIOD
        loop.command(now, Velocity(0.3))
        loop.measure(now, Velocity(0.3))
    assert loop.seconds == pytest.approx(0.5, abs=0.5 * STEP)


@pytest.mark.parametrize("delay", [0.0, 0.3, 1.0])
def test_the_prediction_is_what_the_robot_does_by_commands_in_transit(delay: float) -> None:
    loop = driven(delay)
    now = 110.0 - PERIOD  # of the last odometry and command
    expected = HERE
    for number in range(round(delay / PERIOD)):
        expected = advance(expected, winding(now - delay + number * PERIOD), PERIOD)
    pose, velocity = loop.ahead(now, HERE, winding(now - delay))
    assert pose == pytest.approx(expected, abs=1e-6)
    assert velocity == pytest.approx(winding(now - PERIOD if delay else now), abs=0.1)


def test_the_age_of_odometry_is_part_of_the_prediction() -> None:
    loop = driven(0.0)
    last, now = 110.0 - PERIOD, 110.0 + 0.1
    pose, _ = loop.ahead(now, HERE, winding(last))
    assert pose == pytest.approx(advance(HERE, winding(last), now - last), abs=1e-6)


def test_what_a_controller_knows_itself_is_not_predicted() -> None:
    loop = driven(0.3)
    now = 110.0 - PERIOD
    whole, part = (loop.ahead(now, HERE, winding(now - 0.3), known)[0] for known in (0.0, 0.1))
    assert 0.0 < part.distance_to(HERE) < whole.distance_to(HERE)
    assert loop.ahead(now, HERE, Velocity(), 0.3) == (HERE, Velocity())


def test_a_robot_that_does_not_follow_its_commands_is_where_it_is_measured() -> None:
    """Somebody holds it, or its wheels are blocked."""
    loop = driven(0.3)
    for number in range(40):
        loop.command(110.0 + number * PERIOD, Velocity(0.5))
        loop.measure(110.0 + number * PERIOD, Velocity())
    assert loop.ahead(112.0, HERE, Velocity()) == (HERE, Velocity())


def test_without_odometry_or_commands_nothing_is_predicted() -> None:
    loop = LoopDelay()
    assert loop.ahead(5.0, HERE, Velocity(0.2)) == (HERE, Velocity(0.2))
    loop.measure(5.0, Velocity(0.2))  # the robot was driven by somebody else
    assert loop.ahead(5.0, HERE, Velocity(0.2)) == (HERE, Velocity(0.2))


@pytest.mark.parametrize("jump", [-1000.0, -1.0, -0.1, 0.1, 1.0, 1000.0])
def test_a_clock_of_the_robot_that_is_set_does_not_count_as_delay(jump: float) -> None:
    loop = driven(0.3, stamped=True)
    for number in range(200):
        now = 110.0 + number * PERIOD
        loop.command(now, winding(now))
        loop.measure(now, winding(now - 0.3), 1000.0 + now + jump)
    assert loop.seconds == pytest.approx(0.3, abs=0.5 * STEP)
