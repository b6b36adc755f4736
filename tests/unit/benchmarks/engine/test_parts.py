"""Parts of the engine bench: capacity, the master, messages within a container, and a robot that talks."""

import asyncio
from typing import Any

from benchmarks.engine.capacity import capacity_figures
from benchmarks.engine.master import PlacedRobot, survived
from benchmarks.engine.messages import in_one_container
from benchmarks.engine.talking_robot import STEP, ReceivedPositions


def test_the_number_of_containers_is_reported_with_the_first_error() -> None:
    figures = capacity_figures(3, [0.1, 0.2], ["Unavailable: no machine has room"], [0.01], [12_000_000, 14_000_000])
    first = figures[0]
    assert (first.value, first.kept) == (2, False)
    assert "no machine has room" in first.note
    assert {figure.name: figure.value for figure in figures}["memory of all"] == 26.0


def test_other_figures_are_omitted_if_no_container_answers() -> None:
    assert [figure.value for figure in capacity_figures(3, [], ["Unavailable: why"], [], [])] == [0]


STATE: dict[str, Any] = {"settings": {"m1": {"max_containers": 3}, "m2": {"draining": True}}, "removed": ["m9"]}
BEFORE = {"r1": PlacedRobot("m1", "c1", "", kept=True), "r2": PlacedRobot("m3", "c2", "")}


def counted(after: dict[str, PlacedRobot], still: dict[str, Any]) -> dict[str, bool | None]:
    return {figure.name: figure.kept for figure in survived(BEFORE, after, STATE, still, 1.0)}


def test_a_master_that_lost_nothing_is_within_all_limits() -> None:
    after = {"r1": PlacedRobot("m3", "c7", "c1"), "r2": PlacedRobot("m1", "c8", ""), "r3": PlacedRobot("m1", "c9", "")}
    assert False not in counted(after, STATE).values()


def test_lost_checkpoints_and_settings_exceed_the_limits() -> None:
    kept = counted({"r1": PlacedRobot("m3", "c7", "")}, {"settings": {"m1": {"max_containers": 4}}, "removed": []})
    assert kept["placements made anew"] is False
    assert kept["checkpoints gone on from"] is False
    assert kept["settings of machines kept"] is False


def test_placements_on_drained_or_removed_machines_exceed_the_limit() -> None:
    for machine in ("m2", "m9"):
        after = {"r1": PlacedRobot(machine, "c7", "c1"), "r2": PlacedRobot("m1", "c8", "")}
        assert counted(after, STATE)["placed where none may be"] is False


def test_each_round_is_timed() -> None:
    seconds = in_one_container(20)
    assert len(seconds) == 20
    assert all(0.0 < second < 1.0 for second in seconds)


async def test_a_position_received_earlier_or_later_is_found() -> None:
    received = ReceivedPositions()
    received.note(1.0, 2.0)
    at = await received.of(2.0)
    assert at == received.times[0][0]
    later = asyncio.create_task(received.of(3.0))
    await asyncio.sleep(0)
    received.note(2.0 + STEP)
    received.note(3.0)
    assert await later == received.times[-1][0]


async def test_the_wait_for_a_lost_position_has_a_time_limit() -> None:
    received = ReceivedPositions()
    received.note(1.0 + STEP)
    assert await received.of(1.0) is None
