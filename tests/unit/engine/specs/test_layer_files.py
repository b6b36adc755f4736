"""Files of map layers, and the layers that a robot needs."""

from dataclasses import replace

import numpy as np
import pytest

from engine.specs.containers import ContainerSpec, MapVersion
from engine.specs.layer_files import MAP_JSON, open_index, open_layers, write_index, write_layers
from engine.specs.robot_layers import filters_of, layers_of
from ppaas.costmap.costmap import Costmap
from ppaas.costmap.global_parameters import CostParameters
from ppaas.costmap.map_layers import MapLayers
from ppaas.errors import InvalidParameter, Unavailable
from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridInfo, GridMap
from ppaas.maps.occupancy import from_message
from ppaas.messages import decode
from ppaas.messages.nav_msgs import OccupancyGrid
from tests.support.engine.specs import HOUSE, planning_spec, robot_config


@pytest.fixture
def layers() -> MapLayers:
    info = GridInfo(0.05, 7, 5, Pose2D(-1.0, 2.0, 0.5))
    rng = np.random.default_rng(3)
    grid = GridMap(rng.choice(np.array([-1, 0, 100], np.int8), (5, 7)), info)
    costmap = Costmap(rng.integers(0, 256, (5, 7)).astype(np.uint8), info)
    return MapLayers(grid, costmap, rng.random((5, 7), np.float32))


def test_layers_round_trip(tmp_path, layers):
    write_layers(tmp_path, layers, created=12.5)
    found = open_layers(tmp_path)
    assert found.grid.info == found.costmap.info == layers.grid.info
    np.testing.assert_array_equal(found.grid.data, layers.grid.data)
    np.testing.assert_array_equal(found.costmap.data, layers.costmap.data)
    np.testing.assert_array_equal(found.distance, layers.distance)


def test_masks_round_trip_and_are_read_only(tmp_path, layers):
    rng, info = np.random.default_rng(4), layers.grid.info
    keepout, speed = (GridMap(rng.integers(0, 101, (5, 7)).astype(np.int8), info) for _ in "ab")
    masked = replace(layers, keepout=keepout, barred_distance=rng.random((5, 7), np.float32), speed=speed)
    write_layers(tmp_path, masked, created=0.0)
    found = open_layers(tmp_path)
    np.testing.assert_array_equal(found.keepout.data, keepout.data)
    np.testing.assert_array_equal(found.speed.data, speed.data)
    np.testing.assert_array_equal(found.to_lethal, masked.barred_distance)
    np.testing.assert_array_equal(found.distance, layers.distance)
    assert not any(array.flags.writeable for array in (found.keepout.data, found.speed.data, found.to_lethal))


def test_distances_to_lethal_cells_round_trip_without_masks(tmp_path, layers):
    lethal = np.random.default_rng(5).random((5, 7), np.float32)
    write_layers(tmp_path, replace(layers, barred_distance=lethal), created=0.0)
    found = open_layers(tmp_path)
    np.testing.assert_array_equal(found.to_lethal, lethal)
    assert found.keepout is None


def test_opened_layers_are_read_only(tmp_path, layers):
    write_layers(tmp_path, layers, created=0.0)
    found = open_layers(tmp_path)
    for array in (found.grid.data, found.costmap.data, found.distance):
        assert type(array) is np.ndarray
        with pytest.raises(ValueError, match="read-only"):
            array[0, 0] = 1


def test_the_map_is_stored_as_a_message(tmp_path, layers):
    write_layers(tmp_path, layers, created=12.5)
    message = decode(OccupancyGrid, (tmp_path / MAP_JSON).read_bytes())
    assert message.header.frame_id == "map"
    assert message.info.map_load_time.seconds() == 12.5
    np.testing.assert_array_equal(from_message(message).data, layers.grid.data)


@pytest.mark.parametrize("broken", ["grid.npy", "info.json", "distance.npy"])
def test_incomplete_layers_are_unavailable(tmp_path, layers, broken):
    write_layers(tmp_path, layers, created=0.0)
    whole = (tmp_path / broken).read_bytes()
    for content in (b"", whole[: len(whole) // 2]):
        (tmp_path / broken).write_bytes(content)
        with pytest.raises(Unavailable, match="no complete map layers"):
            open_layers(tmp_path)
    (tmp_path / broken).unlink()
    with pytest.raises(Unavailable, match="no complete map layers"):
        open_layers(tmp_path)


def test_index_round_trips_and_is_read_only(tmp_path):
    assert open_index(tmp_path, "p") is None
    write_index(tmp_path, "p", memoryview(b"some words"))
    content = open_index(tmp_path, "p")
    assert bytes(content) == b"some words"
    assert content.readonly
    assert [file.name for file in tmp_path.iterdir()] == ["p.index"]


def test_index_without_a_folder_or_content_is_unavailable(tmp_path):
    with pytest.raises(Unavailable, match="cannot be written"):
        write_index(tmp_path / "gone", "p", memoryview(b"words"))
    (tmp_path / "p.index").touch()
    with pytest.raises(Unavailable, match="cannot be read"):
        open_index(tmp_path, "p")


KEPT, SLOW = MapVersion("kept", "v3"), MapVersion("slow", "v1")


def test_a_planning_container_has_no_filters() -> None:
    layers = layers_of(planning_spec())
    assert (layers.robot_radius, layers.masks, layers.heights) == (0.18, {}, None)
    assert filters_of(layers) == {}


def test_costs_of_the_global_costmap_are_those_of_the_robots_file() -> None:
    given = {"global_costmap": {"inflation_radius": 0.3, "cost_scaling_factor": 10.0, "robot_radius": 0.2}}
    layers = layers_of(ContainerSpec("c1", "ann", HOUSE, 1.0, robot_config(parameters=given)))
    assert (layers.robot_radius, layers.costs) == (0.2, CostParameters(inflation_radius=0.3))
    assert filters_of(layers) == {"global_costmap": {"inflation_radius": 0.3}}
    with pytest.raises(InvalidParameter, match="inflation_radius must be from 0 to 100"):
        wrong = robot_config(parameters={"global_costmap": {"inflation_radius": -1}})
        layers_of(ContainerSpec("c1", "ann", HOUSE, 1.0, wrong))


def test_plans_depend_on_the_keepout_filter_and_not_on_the_speed_filter() -> None:
    masks = {"keepout_filter": KEPT, "speed_filter": SLOW}
    robot = robot_config(model="turtlebot3_burger", masks=masks, in_space=True)
    layers = layers_of(ContainerSpec("c1", "ann", HOUSE, 1.0, robot))
    assert (layers.map, layers.robot_radius, layers.masks, layers.heights) == (HOUSE, 0.105, masks, (None, 0.192))
    assert filters_of(layers) == {"keepout_filter": "kept@v3", "voxel_layer": (None, 0.192)}
    slowed = robot_config(masks={"speed_filter": SLOW})
    assert filters_of(layers_of(ContainerSpec("c1", "ann", HOUSE, 1.0, slowed))) == {}
