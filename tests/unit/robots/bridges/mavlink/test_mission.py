"""A rover that drives missions: uploaded, watched, and left to everybody else."""

import math

import numpy as np
import pytest

from ppaas.messages.nav2_motions import FollowPathError
from ppaas.wire.vda5050.master.instructions import PathEnded
from robots.bridges.mavlink.authority import SendMessage, VehicleAuthority
from robots.bridges.mavlink.dialect import mavlink
from robots.bridges.mavlink.mission import STUCK, MissionDrive, Phase, items_of
from robots.bridges.mavlink.vehicle import Vehicle
from robots.sim.mavlink.rover import Make
from tests.support.mavlink.closed_loop import ANCHOR, ClosedLoop

MAKES = pytest.mark.parametrize("make", ["ardupilot", "px4"])


def looped(make: Make, **options: bool) -> ClosedLoop:
    """Return a rover that has been heard and is localized."""
    loop = ClosedLoop(make, waypoints=True, **options)
    loop.run(2.0)
    assert loop.cloud.motions
    return loop


@MAKES
def test_a_path_is_driven_to_its_end_corner_by_corner(make: Make) -> None:
    loop = looped(make)
    loop.follow("p", (3.0, 0.0), (3.0, 4.0))
    corner = [math.inf]

    def there() -> bool:
        corner[0] = min(corner[0], math.hypot(loop.truth.x - 3.0, loop.truth.y))
        return bool(loop.cloud.ends)

    loop.until(there)
    assert loop.cloud.ends == [PathEnded("p", FollowPathError.NONE)]
    assert math.hypot(loop.truth.x - 3.0, loop.truth.y - 4.0) < 0.5
    assert corner[0] < 0.5
    assert loop.cloud.rests[0] == pytest.approx(7.0, abs=0.5) and loop.cloud.rests[-1] < 1.5
    loop.until(lambda: loop.sim.mode == loop.sim.modes.hold, 3.0)


@MAKES
def test_another_path_replaces_the_first_and_a_cancelled_one_stops(make: Make) -> None:
    loop = looped(make)
    loop.follow("p", (9.0, 0.0))
    loop.until(lambda: loop.sim.body.speed > 0.5)
    loop.follow("q", (0.0, 3.0))
    loop.until(lambda: loop.truth.y > 1.0)
    assert not loop.cloud.ends
    loop.rover.cancel("p", loop.now)  # it was replaced
    loop.run(0.5)
    assert loop.sim.mode == loop.sim.modes.mission
    loop.rover.cancel("q", loop.now)
    loop.run(2.0)
    assert loop.sim.mode == loop.sim.modes.hold and abs(loop.sim.body.speed) < 0.01
    assert not loop.cloud.ends


@MAKES
def test_the_end_counts_although_the_report_of_it_is_lost(make: Make) -> None:
    loop = looped(make)
    loop.follow("p", (2.0, 0.0))
    take = loop.rover.take

    def lossy(message: object, now: float) -> None:
        if message.get_type() != "MISSION_ITEM_REACHED":  # type: ignore[attr-defined]
            take(message, now)

    loop.rover.take = lossy  # type: ignore[method-assign]
    loop.until(lambda: loop.cloud.ends, 20.0)
    assert loop.cloud.ends == [PathEnded("p", FollowPathError.NONE)]


def test_a_rover_that_has_not_yet_begun_to_drive_a_short_path_is_not_at_its_end() -> None:
    loop = looped("ardupilot")
    loop.sim.body.top_speed = loop.sim.body.top_turn = 0.0  # as one whose motors take their time
    here = loop.cloud.motions[-1].pose
    loop.follow("p", (here.x - 1.0, here.y))
    loop.run(8.0)
    assert not loop.cloud.ends


@MAKES
def test_a_rover_that_another_station_takes_ends_its_path_with_the_name_of_the_mode(make: Make) -> None:
    loop = looped(make)
    loop.follow("p", (9.0, 0.0))
    loop.until(lambda: loop.sim.body.speed > 0.5)
    loop.sim.order("mode MANUAL")
    loop.until(lambda: loop.cloud.ends, 3.0)
    assert "switched to MANUAL" in loop.cloud.ends[0].reason
    loop.run(3.0)
    assert loop.sim.mode.name == "MANUAL"
    loop.follow("q", (9.0, 0.0))
    loop.until(lambda: loop.sim.mode == loop.sim.modes.mission, 5.0)


def test_a_rover_that_is_taken_while_its_mission_is_uploaded_is_not_taken_back() -> None:
    loop = looped("ardupilot")
    loop.follow("p", (9.0, 0.0))
    loop.sim.order("mode MANUAL")
    loop.until(lambda: loop.cloud.ends, 2.0)
    assert "switched to MANUAL" in loop.cloud.ends[0].reason
    loop.run(3.0)
    assert loop.sim.mode.name == "MANUAL"


@MAKES
def test_a_rover_that_loses_its_gps_stands_and_says_the_type_of_the_fix(make: Make) -> None:
    loop = looped(make)
    loop.follow("p", (9.0, 0.0))
    loop.until(lambda: loop.sim.body.speed > 0.5)
    loop.sim.order("fix 1")
    loop.until(lambda: loop.cloud.ends, 6.0)
    assert "fix type 1" in loop.cloud.ends[0].reason and "fix type 1" in loop.cloud.problems[-1]
    loop.run(2.0)
    assert loop.sim.mode == loop.sim.modes.hold and abs(loop.sim.body.speed) < 0.01
    count = len(loop.cloud.motions)
    loop.run(1.0)
    assert len(loop.cloud.motions) == count
    loop.sim.order("fix 6")
    loop.run(1.5)
    assert loop.cloud.problems[-1] == "" and len(loop.cloud.motions) > count


def test_a_rover_without_an_armed_motor_and_one_that_is_not_heard_end_their_paths() -> None:
    loop = looped("ardupilot", arm=False)
    loop.follow("p", (9.0, 0.0))
    loop.until(lambda: loop.cloud.ends, 3.0)
    assert "is not armed" in loop.cloud.ends[0].reason
    loop.sim.order("arm")
    loop.run(1.1)
    loop.follow("q", (9.0, 0.0))
    loop.until(lambda: loop.sim.body.speed > 0.5)
    loop.sim.order("mute")
    loop.until(lambda: len(loop.cloud.ends) == 2, 6.0)
    assert loop.cloud.ends[1].path == "q" and loop.cloud.ends[1].code is FollowPathError.UNKNOWN


def test_a_stuck_rover_fails_its_path() -> None:
    loop = looped("ardupilot")
    loop.follow("p", (9.0, 0.0))
    loop.until(lambda: loop.sim.body.speed > 0.5)
    loop.sim.body.top_speed = 0.0
    loop.until(lambda: loop.cloud.ends, STUCK + 5.0)
    assert "has not moved on" in loop.cloud.ends[0].reason


def test_a_stopped_robot_stands() -> None:
    loop = looped("ardupilot")
    loop.follow("p", (9.0, 0.0))
    loop.until(lambda: loop.sim.body.speed > 0.5)
    loop.rover.stop(True, loop.now)
    loop.rover.cancel("p", loop.now)
    loop.run(2.0)
    assert loop.sim.mode == loop.sim.modes.hold and abs(loop.sim.body.speed) < 0.01


def test_a_refused_mission_and_one_without_an_answer_end_the_path() -> None:
    vehicle = Vehicle(1, 1, mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA)
    drive = MissionDrive(VehicleAuthority(vehicle, arm=True), ANCHOR)
    assert [type(step) for step in drive.follow("p", np.array([[0.0, 0.0], [5.0, 0.0]]), 0.0)] == [SendMessage]
    full = mavlink.MAVLink_mission_ack_message(255, 190, mavlink.MAV_MISSION_NO_SPACE)
    assert drive.take(full, 0.1) == [
        PathEnded("p", FollowPathError.INVALID_PATH, "the vehicle refuses the mission: NO_SPACE")
    ]
    drive.follow("q", np.array([[0.0, 0.0], [5.0, 0.0]]), 1.0)
    steps = [step for tenth in range(100) for step in drive.tick(None, 1.0 + 0.1 * tenth)]
    assert sum(isinstance(step, SendMessage) for step in steps) == 4
    assert steps[-1] == PathEnded("q", FollowPathError.UNKNOWN, "the vehicle does not answer to a mission")
    assert drive.phase is Phase.NONE


def test_items_have_degrees_as_integers_and_ardupilots_home_before_them() -> None:
    points = np.array([[10.0, 0.0], [10.0, 20.0]])
    for first in (0, 1):
        items = items_of(points, ANCHOR, first, (1, 1))
        assert [item.seq for item in items] == list(range(2 + first))
        assert [item.current for item in items] == [1, 0] if first == 0 else [0, 1, 0]
        for item, point in zip(items[first:], points, strict=True):
            x, y = ANCHOR.to_map(item.x * 1e-7, item.y * 1e-7)
            assert math.hypot(x - point[0], y - point[1]) < 0.01
