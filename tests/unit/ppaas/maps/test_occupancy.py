"""Grids as occupancy messages."""

import json

import msgspec
import numpy as np
import pytest
from hypothesis import given

from ppaas.errors import InvalidMap, MalformedMessage
from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridInfo, GridMap
from ppaas.maps.occupancy import GridMapMessage, from_message, to_message
from ppaas.messages import decode, encode
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import Pose
from ppaas.messages.nav_msgs import MapMetaData, OccupancyGrid
from tests.support.world.maps import grid_maps, real_map


def same(one: GridMap, other: GridMap) -> bool:
    placed = np.allclose([*one.info.origin[:2]], [*other.info.origin[:2]])
    turned = np.isclose(np.cos(one.info.origin.theta - other.info.origin.theta), 1.0)
    sized = (one.info.resolution, one.info.shape) == (other.info.resolution, other.info.shape)
    return bool(placed and turned and sized and np.array_equal(one.data, other.data))


@given(grid_maps([*range(-1, 101)]))
def test_grid_round_trips_as_message_and_json(grid):
    message = GridMapMessage(grid).to_message()
    assert same(from_message(message), grid)
    assert same(from_message(decode(OccupancyGrid, encode(message))), grid)


@given(grid_maps([*range(-1, 101)]))
def test_json_data_is_a_row_major_list(grid):
    message = json.loads(encode(to_message(grid)))
    assert message["data"] == grid.data.ravel().tolist()
    assert (message["info"]["height"], message["info"]["width"]) == grid.data.shape


def test_frame_and_stamp_are_in_the_message():
    grid = GridMap(np.zeros((1, 1), np.int8), GridInfo(0.05, 1, 1))
    message = to_message(grid, "odom", Time(3, 4))
    assert (message.header.frame_id, message.header.stamp, message.info.map_load_time) == (
        "odom",
        Time(3, 4),
        Time(3, 4),
    )
    assert GridMapMessage(grid).to_message().header == Header(frame_id="map")


def test_cells_out_of_range_are_refused():
    grid = GridMap(np.array([[101]], np.int8), GridInfo(0.05, 1, 1))
    with pytest.raises(InvalidMap, match="101"):
        to_message(grid)


def message_of(data: list[int] | msgspec.Raw, width: int = 2, height: int = 1) -> OccupancyGrid:
    return OccupancyGrid(Header(), MapMetaData(0.05, width, height, Pose.of(Pose2D(0.0, 0.0))), data)


@pytest.mark.parametrize(
    ("data", "reason"),
    [
        ([], "2×1"),
        ([0], "data has 1"),
        ([0, 0, 0], "data has 3"),
        ([0, 101], "101"),
        ([-2, 0], "-2"),
        ([0, 1 << 70], "integers"),
        (["a", 0], "integers"),
        ([None, 0], "integers"),
        (msgspec.Raw(b"[0]"), "data has 1"),
        (msgspec.Raw(b"[0,101]"), "integers"),
        (msgspec.Raw(b"[0,0.5]"), "integers"),
        (msgspec.Raw(b"[0,"), "integers"),
        (msgspec.Raw(b'"ab"'), "integers"),
        (msgspec.Raw(b"\xff"), "integers"),
    ],
)
def test_invalid_cells_are_refused(data, reason):
    with pytest.raises(InvalidMap, match=reason):
        from_message(message_of(data))


@pytest.mark.parametrize(("width", "height"), [(0, 0), (-1, -2), (1 << 40, 1 << 40)])
def test_invalid_sizes_are_refused(width, height):
    with pytest.raises(InvalidMap, match="cells"):
        from_message(message_of([0, 0], width, height))


@pytest.mark.parametrize("data", [b'"ab"', b"[0.5]", b'["a"]', b"{}", b"null", b"7"])
def test_data_other_than_a_list_of_integers_is_malformed(data):
    text = encode(message_of([0, 0])).replace(b"[0,0]", data)
    with pytest.raises(MalformedMessage, match="data"):
        decode(OccupancyGrid, text)


def test_real_map_round_trips(data):
    grid = real_map(data, "tb3_sandbox")
    assert same(from_message(decode(OccupancyGrid, encode(to_message(grid)))), grid)
