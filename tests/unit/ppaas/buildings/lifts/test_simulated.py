import pytest

from ppaas.buildings.lifts.simulated import HOLD, LiftModel, SimulatedLift
from ppaas.buildings.lifts.states import EndSession, LiftRequest

LEVELS = {"L1": 0.0, "L2": 4.0, "L3": 8.0}


def lift(**model):
    return SimulatedLift("A", LEVELS, 0.0, LiftModel(**model))


def drive(simulated, floor, start=0.0, seconds=60.0, session="s"):
    """Request a floor each second; return the time at which it stands open there."""
    now = start
    while now < start + seconds:
        now += 1.0
        simulated.request(LiftRequest("A", session, floor), now)
        state = simulated.state(now)
        if (state.floor, state.door, state.motion) == (floor, "open", "stopped"):
            return now
    return None


def test_a_car_drives_with_closed_doors_and_opens_at_the_floor():
    simulated = lift(speed=1.0, acceleration=0.5, doors=2.0)
    assert drive(simulated, "L1") == pytest.approx(3.0, abs=1.1)
    seen = set()
    now = 10.0
    for _ in range(300):
        now += 0.1
        simulated.request(LiftRequest("A", "s", "L3"), now)
        state = simulated.state(now)
        seen.add((state.motion, state.door))
        if state.floor == "L3" and state.door == "open":
            break
    assert ("up", "closed") in seen
    assert not any(motion != "stopped" and door != "closed" for motion, door in seen)
    # 2 s of doors, 8 m at 1 m/s with 2 s of acceleration and of braking, 2 s of doors.
    assert now - 10.0 == pytest.approx(14.0, abs=0.8)


def test_a_session_excludes_others_until_it_is_ended():
    simulated = lift()
    drive(simulated, "L1")
    simulated.request(LiftRequest("A", "other", "L3"), 10.0)
    assert simulated.state(10.0).session == "s"
    simulated.end(EndSession("A", "s"), 11.0)
    simulated.request(LiftRequest("A", "other", "L3"), 12.0)
    assert simulated.state(12.0).session == "other"


def test_a_session_without_requests_ends_by_itself_and_the_doors_close():
    simulated = lift()
    opened = drive(simulated, "L1")
    assert simulated.state(opened + HOLD - 1.0).door == "open"
    assert simulated.state(opened + HOLD + 1.0).session == ""
    assert simulated.state(opened + HOLD + 10.0).door == "closed"


def test_people_take_a_lift_that_nobody_holds_and_give_it_back():
    simulated = lift(people=200.0, seed=3)
    modes = [simulated.state(float(second)).mode for second in range(1200)]
    assert {"agv", "human"} <= set(modes)
    assert modes.count("human") > 60
    end = next(second for second in range(1200, 2400) if simulated.state(float(second)).mode == "agv")
    simulated.request(LiftRequest("A", "s", "L1"), float(end))
    assert simulated.state(float(end)).session == "s"


def test_a_lift_may_stop_at_another_floor_and_come_at_the_second_request():
    simulated = lift(wrong_floor=1.0, seed=1)
    wrong = None
    for second in range(1, 120):
        simulated.request(LiftRequest("A", "s", "L3"), float(second))
        state = simulated.state(float(second))
        if state.door == "open" and state.floor != "L3":
            wrong = state.floor
        if state.door == "open" and state.floor == "L3":
            break
    assert wrong in ("L1", "L2")
    assert simulated.state(120.0).floor == "L3"


def test_in_case_of_fire_the_car_opens_at_the_lowest_floor_and_obeys_nobody():
    simulated = lift()
    opened = drive(simulated, "L3")
    simulated.set_mode("fire", opened)
    state = simulated.state(opened + 60.0)
    assert (state.floor, state.door, state.mode) == ("L1", "open", "fire")
    simulated.request(LiftRequest("A", "s", "L2"), opened + 61.0)
    assert simulated.state(opened + 80.0).floor == "L1"


def test_a_floor_that_does_not_exist_is_ignored():
    simulated = lift()
    simulated.request(LiftRequest("A", "s", "L9"), 1.0)
    assert simulated.state(1.0).session == ""


def test_a_lift_that_breaks_stops_and_says_so():
    lift = SimulatedLift("A", LEVELS, 0.0, LiftModel(breaks=5.0))
    lift.request(LiftRequest("A", "s", "L3"), 0.0)
    assert lift.state(4.9).mode == "agv"
    broken = lift.state(5.2)
    assert (broken.mode, broken.session) == ("offline", "")
    lift.request(LiftRequest("A", "s", "L3"), 5.3)
    assert lift.state(60.0) == lift.state(5.4), "it neither moves nor obeys"


def test_doors_that_are_blocked_open_and_the_car_stays():
    lift = SimulatedLift("A", LEVELS, 0.0)
    lift.request(LiftRequest("A", "s", "L1"), 0.0)
    assert lift.state(5.0).door == "open"
    lift.blocked = True
    lift.request(LiftRequest("A", "s", "L3"), 5.0)
    for now in range(6, 30):
        lift.request(LiftRequest("A", "s", "L3"), float(now))
        assert (lift.state(float(now)).door, lift.state(float(now)).floor) == ("open", "L1")
    lift.blocked = False
    lift.request(LiftRequest("A", "s", "L3"), 30.0)
    assert lift.state(38.9).floor == "L3"
