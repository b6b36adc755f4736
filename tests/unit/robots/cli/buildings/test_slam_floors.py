"""``ppaas slam --floors``: a map of each floor of a drive, and the building that they make."""

import json
from pathlib import Path

import numpy as np
import pytest

from ppaas.buildings.building import building_of
from ppaas.errors import InvalidInput
from robots.cli.command_parser import CommandParser
from robots.cli.commands import slam
from robots.client.map_files import read_map_file
from robots.recordings.bag_heights import heights_of
from tests.support.recordings.bags import make_bag
from tests.support.recordings.floor_bags import ROOMS, STOREY, make_floor_bag


def run(*words: object) -> int:
    parser = CommandParser()
    slam.configure(parser)
    return slam.run(parser.parse_args(list(map(str, words))))


@pytest.mark.parametrize("barometer", [True, False])
def test_a_drive_over_two_floors_gives_two_maps_and_a_building(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], barometer: bool
) -> None:
    bag = make_floor_bag(tmp_path / "ride", barometer=barometer)
    run(bag, "--floors", tmp_path / "mill", "--json")
    rows = json.loads(capsys.readouterr().out)
    assert [(row["floor"], row["map"]) for row in rows] == [("L1", "mill-L1"), ("L2", "mill-L2")]
    building = building_of((tmp_path / "mill" / "building.json").read_bytes())
    assert [floor.elevation for floor in building.floors] == pytest.approx([0.0, STOREY], abs=0.3)
    assert building.floors[1].anchor == pytest.approx((0.0, 0.0, 0.0), abs=0.05), "the lift is one place on both"
    for number, floor in enumerate(building.floors):
        grid = read_map_file(tmp_path / "mill" / f"{floor.map}.yaml")
        rows_of, columns = np.nonzero(grid.data == 100)
        wide = np.ptp(columns) * grid.info.resolution
        assert wide == pytest.approx(ROOMS[number][0], abs=0.3), "the walls of its room, and none of the car"
        assert np.ptp(rows_of) * grid.info.resolution == pytest.approx(ROOMS[number][1], abs=0.3)


def test_bags_without_heights_and_outputs_of_one_map_are_refused(tmp_path: Path) -> None:
    flat = make_floor_bag(tmp_path / "flat", barometer=False, rises=False)
    with pytest.raises(InvalidInput, match="has no heights: floors are found by a barometer"):
        run(flat, "--floors", tmp_path / "mill")
    with pytest.raises(InvalidInput, match="no heights on /air"):
        run(flat, "--floors", tmp_path / "mill", "--height-topic", "/air")
    with pytest.raises(InvalidInput, match="--map is of one map"):
        run(flat, "--floors", tmp_path / "mill", "--map", tmp_path / "out.yaml")
    (tmp_path / "file").write_text("")
    with pytest.raises(InvalidInput, match="cannot write to folder"):
        run(flat, "--floors", tmp_path / "file")


def test_heights_are_read_from_bags_of_ros_1_too(tmp_path: Path) -> None:
    found = heights_of(make_bag(tmp_path / "drive", "bag"), "odom")
    assert found.topic == "/odom" and len(found.stamps) == 30 and not found.heights.any()
    assert np.diff(found.stamps) == pytest.approx(0.1, abs=1e-6)
