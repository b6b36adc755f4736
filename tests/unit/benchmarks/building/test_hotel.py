"""Whole robots in a hotel: they ride, share cars, and touch nobody; bounds and bars are what they say."""

import dataclasses
from pathlib import Path

import pytest

from benchmarks.building.hotel import measure
from benchmarks.building.hotel.house import hotel, imported
from benchmarks.building.hotel.recording import RunRecord
from benchmarks.building.hotel.run import HotelCase, HotelResult, HouseRun
from benchmarks.building.hotel.virtual_time import run_in_virtual_time

CASE = HotelCase(hotel(2), robots=4, seconds=110.0)


def test_robots_ride_to_goals_on_other_floors_and_touch_nobody(tmp_path: Path) -> None:
    run, record = HouseRun(CASE, 1), RunRecord()
    result = run.run(record.watch)
    assert result.goals >= 2 and not result.failed
    assert (result.contacts, result.shut, result.deadlocks) == (0, 0, 0) and result.nearest > 0.0
    assert len(result.waits) >= result.goals <= len(result.drives)
    assert min(result.passages["boarding"]) > 0.0 and min(result.passages["alighting"]) > 0.0
    record.write(tmp_path / "run.png", run)
    assert (tmp_path / "run.png").read_bytes().startswith(b"\x89PNG")


def test_robots_are_led_away_from_a_lift_that_breaks() -> None:
    result = HouseRun(dataclasses.replace(CASE, breaks_at=35.0, first_come=True), 1).run()
    assert 0.0 <= result.rerouted <= measure.REROUTED and result.aboard <= 1


def test_bars_are_missed_by_contacts_and_by_too_few_goals() -> None:
    ours = HotelResult(goals=10, waits=[30.0], drives=[60.0], passages={"boarding": [6.0], "alighting": [6.0]})
    first, broken = HotelResult(goals=9), HotelResult(rerouted=6.0, contacts=1, failed=["robot 1: failed, no way"])
    figures = {each.name: each for each in measure.figures_of(CASE, [ours], [first], [broken])}
    kept = {name: figure.kept for name, figure in figures.items() if figure.kept is not None}
    assert kept == {
        "goals over first come first served": False,
        "mean wait over its bound": False,
        "re-routed after a lift breaks": False,
        "contacts": False,
        "robots in shut doors of lifts": True,
        "deadlocks": True,
        "goals that were not reached": False,
    }
    assert figures["bound of the mean wait"].value == pytest.approx(3.0), "few robots wait until doors have opened"
    many = dataclasses.replace(CASE, robots=20)
    trip = 3.5 + 1.25 + 6.0
    assert measure.least_wait(many, [ours]) == pytest.approx(10.0 * (12.0 + trip / 2.0) - 60.0 - 12.0 - trip)


@pytest.mark.parametrize("name", ["hotel", "door_madness"])
def test_buildings_of_open_rmf_are_driven(name: str, data: Path) -> None:
    house = imported(data / "buildings" / f"{name}.building.yaml")
    result = HouseRun(HotelCase(house, robots=2, capacity=1, seconds=150.0), 2).run()
    assert result.goals >= 1 and not result.failed and not result.contacts


def test_simulated_time_does_not_wait_and_a_sleep_for_ever_is_refused() -> None:
    import asyncio

    async def sleep() -> float:
        await asyncio.gather(asyncio.sleep(3600.0), asyncio.sleep(5.0))
        return asyncio.get_running_loop().time()

    assert run_in_virtual_time(sleep()) == pytest.approx(3600.0)

    async def hang() -> None:
        await asyncio.Event().wait()

    with pytest.raises(RuntimeError, match="waits for ever"):
        run_in_virtual_time(hang())
