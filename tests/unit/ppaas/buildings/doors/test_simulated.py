from ppaas.buildings.doors.simulated import SimulatedDoor
from ppaas.buildings.doors.states import DoorRequest


def test_a_door_whose_way_is_blocked_opens_and_closes_once_it_is_free():
    door = SimulatedDoor("L1", "main", 0.0, 2.0)
    door.request(DoorRequest("L1", "main", "s", "open"), 0.0)
    assert door.state(2.0).mode == "open"
    door.request(DoorRequest("L1", "main", "s", "closed"), 3.0)
    assert door.state(4.0).mode == "moving"
    door.blocked = True
    assert door.state(5.0).mode == "open"
    assert door.state(60.0).mode == "open"
    door.blocked = False
    assert [door.state(time).mode for time in (61.0, 62.0)] == ["moving", "closed"]
