"""Growth of the master: the simulated cloud, its take-over, and the table."""

import gc
from pathlib import Path

import pytest

from benchmarks.placement.arrivals import events, generated
from benchmarks.placement.growth import ROWS, Grown, rows
from benchmarks.placement.growth_process import REFUSED, adopt, time_rare_events, write_registrations
from benchmarks.placement.simulated_cloud import Cost, SimulatedCloud, Sizes, timed_collections


@pytest.fixture
def cloud() -> SimulatedCloud:
    """Return a cloud to which robots came, and half of which went."""
    made = SimulatedCloud(Sizes(machines=4, endpoints=3, robots=120))
    for event in events(generated(120, 5, seed=1)):
        made.take(event)
    return made


def test_robots_that_did_not_go_are_ready_and_connected(cloud: SimulatedCloud) -> None:
    places, costs = cloud.timed.master.places, cloud.timed.costs
    assert {key for key, place in places.items() if place.state == "ready"} == set(cloud.connected(1000))
    assert costs["place"].count == 120 and cloud.rejected == 0
    assert len(places) == 120 - costs["release"].count < 120
    assert costs["roam"].count == costs["round trip"].count > 100
    assert any(machine.served for machine in cloud.timed.master.machines.values())


def test_the_next_master_adopts_every_container(cloud: SimulatedCloud, tmp_path: Path) -> None:
    before = {key: place.spec for key, place in cloud.timed.master.places.items()}
    write_registrations(cloud, tmp_path / "registrations")
    *_, timed = adopt(tmp_path / "registrations")
    assert {key: place.spec for key, place in timed.master.places.items()} == before
    assert timed.costs["adoption"].count == 4


def test_each_rare_event_happens_and_no_robot_is_lost_by_them(cloud: SimulatedCloud) -> None:
    before = set(cloud.connected(1000))
    time_rare_events(cloud)
    costs, places = cloud.timed.costs, cloud.timed.master.places
    released = costs["release while draining"].count
    assert len(before & places.keys()) == len(before) - released
    assert costs["refusal, no room"].count == costs["refusal, no labels"].count == REFUSED
    assert costs["machine lost"].count == costs["endpoint lost"].count == 1


def test_a_cost_has_a_mean_and_the_longest() -> None:
    cost = Cost()
    assert cost.mean == 0.0
    for seconds in (1.0, 3.0):
        cost.add(seconds)
    assert (cost.count, cost.mean, cost.longest) == (2, 2.0, 3.0)


def test_garbage_collections_are_timed_within_the_block() -> None:
    with timed_collections() as cost:
        gc.collect()
    gc.collect()
    assert cost.count >= 1 and 0.0 < cost.longest <= cost.seconds


def test_the_table_has_a_column_for_each_size(cloud: SimulatedCloud, tmp_path: Path) -> None:
    write_registrations(cloud, tmp_path / "registrations")
    *_, timed = adopt(tmp_path / "registrations")
    time_rare_events(cloud)
    costs = (
        cloud.timed.costs | timed.costs | {"collection": Cost(1, 2.0, 2.0), "adoption, collection": Cost(2, 1.0, 0.5)}
    )
    grown = [Grown(size, 3, 120, 80, 0, costs, 0.16) for size in (4, 4_000)]
    cells = {row["master"]: (row["4 machines"], row["4,000 machines"]) for row in rows(grown)}
    assert list(cells) == list(ROWS)
    assert cells["of it each robot"] == ("2,000 bytes",) * 2
    assert cells["longest garbage collection"] == ("2,000.00 ms",) * 2
    assert grown[1].at_rest[0] == pytest.approx(1000 * grown[0].at_rest[0])
