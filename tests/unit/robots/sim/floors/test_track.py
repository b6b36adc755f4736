import pytest

from ppaas.buildings.lifts.states import LiftRequest
from robots.sim.floors.track import PERIOD, BuildingTrack
from tests.support.world.simulated_building import BEFORE, IN_CAR, MODEL, building


def test_a_ride_is_recorded_with_heights_and_ways_on_both_floors() -> None:
    simulated = building()
    simulated.add_robot(IN_CAR, MODEL)
    other = simulated.add_robot(BEFORE, MODEL)
    track = BuildingTrack(simulated)
    for step in range(round(10.0 / simulated.dt)):
        if step % 50 == 0:
            simulated.lifts["A"].request(LiftRequest("A", "s", "up"), simulated.time())
        simulated.step()
        track.after_step()
    rode, waited = track.robots
    assert [time for time, _ in waited.heights] == pytest.approx([PERIOD * n for n in range(20)], abs=0.03)
    assert {height for _, height in waited.heights} == {0.0}
    heights = [height for _, height in rode.heights]
    assert heights == sorted(heights) and (heights[0], heights[-1]) == (0.0, 3.0)
    assert any(0.5 < height < 2.5 for height in heights), "it is seen between the floors"
    assert rode.heights == track.cars["A"], "it is in the car"
    assert set(rode.ways) == {"low", "up"} and set(waited.ways) == {"low"}
    assert waited.ways["low"][0][0] == pytest.approx(BEFORE[:2])
    assert simulated.height_of(other) == 0.0
