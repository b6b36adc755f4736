"""``ppaas bench placement`` on a few robots."""

import json
from itertools import pairwise
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.placement.arrivals import RobotArrival, events, generated, recorded
from benchmarks.placement.balancers import Spread
from ppaas.errors import InvalidInput
from robots.cli.main import main
from tests.support.engine.placing import spec

PLACEMENT = ["bench", "placement", "--only", "balancers", "--json"]
ARGUMENTS = [*PLACEMENT, "--robots", "400", "--machines", "30", "--cores", "2", "--maps", "20"]


def test_both_balancers_place_the_same_robots(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(ARGUMENTS) == 0
    result = json.loads(capsys.readouterr().out)
    first_fit, ppaas = result["balancers"]["first_fit"], result["balancers"]["ppaas"]
    assert first_fit["placed"] + first_fit["rejected"] == ppaas["placed"] + ppaas["rejected"] == result["robots"] == 400
    assert ppaas["cross_machine_mb_per_second"] < first_fit["cross_machine_mb_per_second"]
    assert ppaas["layers_gb"] < first_fit["layers_gb"]
    assert main(ARGUMENTS) == 0
    again = json.loads(capsys.readouterr().out)
    for name in result["balancers"]:
        for figures in (result["balancers"][name], again["balancers"][name]):
            assert figures.pop("placements_per_second") > 0
    assert result == again


def test_rejected_robots_are_counted(capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*ARGUMENTS, "--machines", "1", "--balancer", "first_fit"]) == 0
    result = json.loads(capsys.readouterr().out)
    assert list(result["balancers"]) == ["first_fit"]
    assert result["balancers"]["first_fit"]["rejected"] > 300


def test_recorded_robots_are_placed_in_their_order(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "arrivals.jsonl"
    file.write_text(
        "".join(json.dumps({"at": n, "robot": f"r{n}", "map": "office", "stays": 1.5}) + "\n" for n in range(50))
    )
    assert main([*PLACEMENT, "--machines", "1", "--cores", "1", "--arrivals", str(file)]) == 0
    result = json.loads(capsys.readouterr().out)
    assert result["robots"] == 50
    assert result["balancers"]["ppaas"]["placed"] == 50


@pytest.mark.parametrize(
    "line",
    [
        "nonsense",
        '{"at": 1}',
        '{"at": 0, "robot": "r", "map": "m", "cores": 0}',
        '{"at": -1, "robot": "r", "map": "m"}',
    ],
)
def test_an_invalid_line_is_reported_by_its_number(tmp_path: Path, line: str) -> None:
    file = tmp_path / "arrivals.jsonl"
    file.write_text('{"at": 0, "robot": "r0", "map": "m"}\n' + line + "\n")
    with pytest.raises(InvalidInput, match="line 2"):
        list(recorded(file))


def test_an_unknown_balancer_is_refused_with_the_known_ones(capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*ARGUMENTS, "--balancer", "best"]) != 0
    assert "first_fit, ppaas" in capsys.readouterr().err


def test_events_are_in_order_and_departures_follow_arrivals() -> None:
    seen, here = list(events(generated(300, 10, 1))), set[int]()
    assert all(one.at <= two.at for one, two in pairwise(seen))
    for event in seen:
        if event.comes:
            here.add(event.number)
        else:
            here.remove(event.number)
    assert sum(event.comes for event in seen) == 300
    assert len(here) < 300


def test_robots_without_a_departure_do_not_leave() -> None:
    assert [
        event.comes for event in events(iter([RobotArrival(0.0, "a", "m"), RobotArrival(1.0, "b", "m", stays=1.0)]))
    ] == [True] * 2


@given(st.lists(st.tuples(st.sampled_from("ab"), st.sampled_from("xyz")), max_size=40), st.data())
def test_incremental_counts_equal_counts_from_scratch(pairs: list[tuple[str, str]], data: st.DataObject) -> None:
    spread, here = Spread(), list[tuple[str, str]]()
    for map_id, machine in pairs:
        if here and data.draw(st.booleans()):
            gone = here.pop(data.draw(st.integers(0, len(here) - 1)))
            spread.count(gone[1], spec("c", map_id=gone[0]), -1)
        spread.count(machine, spec("c", map_id=map_id), 1)
        here.append((map_id, machine))
    hosts = {map_id: {where for each, where in here if each == map_id} for map_id in "ab"}
    assert spread.copies == sum(map(len, hosts.values()))
    assert spread.messages == sum(max(len(hosts[map_id]) - 1, 0) for map_id, _ in here)
