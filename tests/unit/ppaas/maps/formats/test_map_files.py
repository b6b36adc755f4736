"""Map files of map_server, good and bad; occupancy of pixels by its rules and Nav2's, against slow twins."""

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from ppaas.errors import InvalidMap
from ppaas.geometry import Pose2D
from ppaas.maps.formats.image import MapImage
from ppaas.maps.formats.map_files import load_map, occupancy, save_map
from ppaas.maps.formats.map_yaml import MapYaml, Mode, Rules, parse_yaml
from ppaas.maps.formats.netpbm import open_pgm, write_pgm
from tests.reference.maps import map_image as twin
from tests.support.world.maps import YAML, grid_maps, real_map
from tests.support.world.png import png

PIXELS = np.array([[0, 88, 89, 90, 204, 205, 206, 254, 255]], np.uint8)
IMAGE = write_pgm(PIXELS)


@given(grid_maps([-1, 0, 100]))
def test_a_saved_map_loads_cell_for_cell(grid):
    record, image = save_map(grid, "map.pgm")
    loaded = load_map(record, image)
    assert np.array_equal(loaded.data, grid.data)
    assert loaded.info == grid.info
    assert parse_yaml(record).mode is Mode.TRINARY


@given(grid_maps([-1, 0, 1, 42, 99, 100]))
def test_graded_cells_round_trip(grid):
    record, image = save_map(grid, "map.pgm")
    assert np.array_equal(load_map(record, image).data, grid.data)


@given(st.text(min_size=1))
def test_any_image_name_round_trips(name):
    grid = load_map(YAML, IMAGE)
    assert parse_yaml(save_map(grid, name)[0]).image == name


def test_save_map_writes_the_pixels_of_map_saver():
    grid = load_map(YAML, write_pgm(np.array([[254, 0, 205]], np.uint8)))
    assert grid.data.tolist() == [[0, 100, -1]]
    assert save_map(grid, "a.pgm")[1] == b"P5\n3 1\n255\n\xfe\x00\xcd"


def test_the_top_row_of_the_image_is_the_last_of_the_grid():
    grid = load_map(YAML, write_pgm(np.array([[0], [254]], np.uint8)))
    assert grid.data.tolist() == [[0], [100]]


def test_trinary_thresholds_compare_like_in_map_server():
    # (255 − 89) / 255 = 0.651 > 0.65; (255 − 205) / 255 = 0.19608 > 0.196
    assert load_map(YAML, IMAGE).data.tolist() == [[100, 100, 100, -1, -1, -1, 0, 0, 0]]


def test_a_cell_exactly_at_a_threshold_is_neither_free_nor_occupied():
    record = YAML.replace(b"0.65", b"1.0").replace(b"0.196", b"0.0")
    assert set(load_map(record, IMAGE).data.ravel().tolist()) == {-1}


def test_negate_inverts_the_greys():
    negated = load_map(YAML.replace(b"negate: 0", b"negate: 1"), write_pgm(255 - PIXELS))
    assert np.array_equal(negated.data, load_map(YAML, IMAGE).data)


def test_scale_grades_between_the_thresholds():
    record = YAML.replace(b"0.65", b"1.0").replace(b"0.196", b"0.0") + b"mode: scale\n"
    pixels = np.array([[255, 254, 128, 1, 0]], np.uint8)
    expected = [int(1 + 98 * (255 - int(p)) / 255) for p in pixels[0]]
    assert load_map(record, write_pgm(pixels)).data.tolist() == [expected]


def test_raw_keeps_values_up_to_100_and_maps_others_to_unknown():
    pixels = np.array([[0, 1, 100, 101, 205, 255]], np.uint8)
    assert load_map(YAML + b"mode: raw\n", write_pgm(pixels)).data.tolist() == [[0, 1, 100, -1, -1, -1]]


def test_keys_with_defaults_may_be_left_out():
    keys = parse_yaml(b"image: a.pgm\nresolution: .05\norigin: [-1, 2.5, 1e-1]\n")
    assert (keys.resolution, keys.origin, keys.negate, keys.mode) == (0.05, (-1.0, 2.5, 0.1), False, Mode.TRINARY)
    assert (keys.occupied_thresh, keys.free_thresh) == (0.65, 0.196)


@pytest.mark.parametrize(
    ("text", "number"),
    [("-.5", -0.5), ("+.5", 0.5), ("5.", 5.0), ("5e-2", 0.05), ("+1E+2", 100.0), ("'-1'", -1.0), ("010", 10.0)],
)
def test_numbers_are_read_as_c_plus_plus_reads_them(text, number):
    origin = f"[{text}, '{text.strip(chr(39))}', {text}]".encode()
    assert parse_yaml(YAML.replace(b"[0.0, 0.0, 0.0]", origin)).origin == (number, number, number)


@pytest.mark.parametrize(
    ("text", "negate"),
    [
        ("0", False),
        ("1", True),
        ("7", True),
        ("0.0", False),
        ("yes", True),
        ("Off", False),
        ("TRUE", True),
        ("n", False),
    ],
)
def test_negate_is_a_number_or_a_word_of_yaml(text, negate):
    assert parse_yaml(YAML.replace(b"negate: 0", b"negate: " + text.encode())).negate is negate


@pytest.mark.parametrize("line", [b"mode:\n", b"mode: ~\n", b"mode: Trinary\n", b"mode: TRINARY\n"])
def test_a_mode_is_a_word_in_any_case_and_may_be_empty(line):
    assert parse_yaml(YAML + line).mode is Mode.TRINARY


def test_an_origin_may_have_more_numbers_by_the_rules_of_map_server_alone():
    record = YAML.replace(b"[0.0, 0.0, 0.0]", b"[1.0, 2.0, 3.0, 0.0]")
    assert parse_yaml(record).origin == (1.0, 2.0, 3.0)
    with pytest.raises(InvalidMap, match="three numbers by Nav2's rules, not 4"):
        parse_yaml(record, Rules.NAV2)


@pytest.mark.parametrize(
    ("occupied", "free", "by_map_server", "by_nav2"),
    [
        # Occupancies of the pixels: 1, 0.651, 0.4, 0.2, 0. map_server asks for occupied first, Nav2 for free.
        (b"0.2", b"0.2", [100, 100, 100, -1, 0], [100, 100, 100, 0, 0]),
        (b"0.1", b"0.9", [100, 100, 100, 100, 0], [100, 0, 0, 0, 0]),
    ],
)
@pytest.mark.parametrize("mode", [b"", b"mode: scale\n"])
def test_thresholds_may_be_equal_or_crossed(occupied, free, by_map_server, by_nav2, mode):
    record = YAML.replace(b"0.65", occupied).replace(b"0.196", free) + mode
    image = write_pgm(np.array([[0, 89, 153, 204, 255]], np.uint8))
    assert load_map(record, image).data.tolist() == [by_map_server]
    assert load_map(record, image, Rules.NAV2).data.tolist() == [by_nav2]


def test_the_origin_keeps_its_yaw():
    assert load_map(YAML.replace(b"[0.0, 0.0, 0.0]", b"[1, 2, 0.5]"), IMAGE).info.origin == Pose2D(1.0, 2.0, 0.5)


@pytest.mark.parametrize(
    ("record", "named"),
    [
        (b"", "map_server record"),
        (b"just words", "map_server record"),
        (b"[1, 2]", "map_server record"),
        (b"resolution: 0.05\norigin: [0, 0, 0]\n", "`image`"),
        (YAML.replace(b"a.pgm", b"''"), "image"),
        (YAML.replace(b"0.05", b"0"), "resolution"),
        (YAML.replace(b"0.05", b"-1"), "resolution"),
        (YAML.replace(b"0.05", b"abc"), "resolution"),
        (YAML.replace(b"0.05", b".inf"), "resolution"),
        (YAML.replace(b"0.05", b".nan"), "resolution"),
        (YAML.replace(b"[0.0, 0.0, 0.0]", b"[0.0, 0.0]"), "origin"),
        (YAML.replace(b"[0.0, 0.0, 0.0]", b"[0.0, 0.0, .nan]"), "origin"),
        (YAML.replace(b"[0.0, 0.0, 0.0]", b"{x: 1}"), "origin"),
        (YAML.replace(b"0.65", b"1.5"), "occupied_thresh"),
        (YAML.replace(b"0.196", b"-0.1"), "free_thresh"),
        (YAML.replace(b"0.196", b".nan"), "free_thresh"),
        (YAML.replace(b"0.65", b"65"), "occupied_thresh"),
        (YAML.replace(b"0.65", b""), "`occupied_thresh` must be a finite number, as 0.05, not nothing"),
        (YAML.replace(b"0.05", b"0,05"), "`resolution` must be a finite number, as 0.05, not '0,05'"),
        (YAML.replace(b"0.05", b"1_0"), "resolution"),
        (YAML.replace(b"0.05", b"0:05"), "resolution"),
        (YAML.replace(b"0.05", b"9" * 400), "finite"),
        (YAML.replace(b"[0.0, 0.0, 0.0]", b"[0.0, 0.0, []]"), "origin"),
        (YAML.replace(b"negate: 0", b"negate: maybe"), "negate"),
        (YAML + b"mode: [scale]\n", "mode"),
        (YAML + b"mode: colour\n", "mode"),
        (b"image: [", "cannot be read"),
        (b"\xff\xfe\x00", "cannot be read"),
        (b"!!python/object/apply:os.getcwd []", "map_server record"),
        (b"resolution: !!float x", "resolution"),
        (b"negate: !!bool x", "negate"),
        (b"image: !!timestamp x", "`resolution`"),
        (b"[" * 5000, "cannot be read"),
        (b"#" * (1 << 17), "bytes"),
    ],
)
def test_an_invalid_record_is_refused_with_the_name_of_the_key(record, named):
    with pytest.raises(InvalidMap, match=named):
        load_map(record, IMAGE)


@given(st.one_of(st.binary(max_size=80), st.text(max_size=80).map(str.encode)))
def test_arbitrary_bytes_raise_invalid_map_only(rubbish):
    for record in (rubbish, YAML + rubbish, b"image: " + rubbish):
        try:
            assert math.isfinite(parse_yaml(record).resolution)
        except InvalidMap as error:
            assert str(error)


@pytest.mark.parametrize(
    ("name", "shape", "resolution", "values"),
    [
        ("turtlebot3", (384, 384), 0.05, {-1, 0, 100}),
        ("tb3_sandbox", (384, 384), 0.05, {-1, 0, 100}),
        ("depot", (307, 604), 0.05, {0, 100}),
        ("depot_keepout", (307, 604), 0.05, {0, 100}),
        ("depot_speed", (307, 604), 0.05, {1, 20, 25, 50, 99}),
        ("warehouse", (1674, 1006), 0.03, {-1, 0, 100}),
        ("warehouse_keepout", (1674, 1006), 0.03, {-1, 0, 100}),
        ("warehouse_speed", (1674, 1006), 0.03, {1, 20, 99}),
    ],
)
def test_real_maps_round_trip(data, name, shape, resolution, values):
    grid = real_map(data, name)
    assert grid.data.shape == shape
    assert grid.info.resolution == resolution
    assert values == set(np.unique(grid.data).tolist())
    again = load_map(*save_map(grid, f"{name}.pgm"))
    assert np.array_equal(again.data, grid.data)
    assert again.info == grid.info


@pytest.mark.parametrize("name", ["turtlebot3", "depot_speed"])
def test_real_map_is_equal_as_png_and_as_text(data, name):
    folder = data / "ros"
    record, image = (folder / f"{name}.yaml").read_bytes(), (folder / f"{name}.pgm").read_bytes()
    opened, cells = open_pgm(image), load_map(record, image).data
    pixels = opened.rows(0, opened.shape[0])
    as_png = png([row.tobytes() for row in pixels], pixels.shape[1])
    as_text = b"P2 %d %d 255\n" % pixels.shape[::-1] + b"\n".join(b" ".join(b"%d" % p for p in row) for row in pixels)
    assert np.array_equal(load_map(record, as_png).data, cells)
    assert np.array_equal(load_map(record, as_text).data, cells)


def test_real_speed_mask_is_read_by_nav2_rules(data):
    folder = data / "ros"
    record, image = (folder / "depot_speed.yaml").read_bytes(), (folder / "depot_speed.pgm").read_bytes()
    by_map_server, by_nav2 = load_map(record, image), load_map(record, image, Rules.NAV2)
    assert set(np.unique(by_map_server.data).tolist()) == {1, 20, 25, 50, 99}
    assert set(np.unique(by_nav2.data).tolist()) == {0, 20, 25, 50, 100}


THRESHOLDS = st.one_of(st.sampled_from([0.0, 0.196, 0.25, 0.65, 1.0, 51 / 255, 204 / 255]), st.floats(0.0, 1.0))
EVERY_PIXEL = st.integers(1, 4).flatmap(
    lambda n: hnp.arrays(
        np.uint8,
        st.tuples(st.integers(1, 6), st.integers(1, 6), st.just(3 if n == 2 else n)),
        elements=st.one_of(st.sampled_from([0, 51, 89, 90, 100, 101, 204, 205, 206, 254, 255]), st.integers(0, 255)),
    )
)
GREYS = np.arange(256, dtype=np.uint8)[np.newaxis, :, np.newaxis]


def record(**keys) -> MapYaml:
    return MapYaml(**({"image": "a.png", "resolution": 0.05, "origin": (0.0, 0.0, 0.0)} | keys))


@given(EVERY_PIXEL, st.sampled_from(Mode), st.booleans(), THRESHOLDS, THRESHOLDS, st.sampled_from(Rules))
def test_occupancy_agrees_with_the_twin(channels, mode, negate, low, high, rules):
    assume(low >= high or np.float32(low) < np.float32(high))
    keys = record(mode=mode, negate=negate, free_thresh=low, occupied_thresh=high, rules=rules)
    expected = getattr(twin, rules.value)(channels, mode.value, negate, high, low)
    assert np.array_equal(occupancy(MapImage(channels), keys), expected)


@pytest.mark.parametrize(
    ("keys", "grey", "by_map_server", "by_nav2"),
    [
        # map_saver's three greys, which both rules read equally.
        ({}, [254, 205, 0], [0, -1, 100], [0, -1, 100]),
        # Exactly at a threshold.
        ({"negate": True, "free_thresh": 51 / 255}, [51], [-1], [0]),
        ({"negate": True, "free_thresh": 0.1, "occupied_thresh": 51 / 255}, [51], [-1], [100]),
        ({"free_thresh": 0.0, "occupied_thresh": 1.0}, [255, 128, 0], [-1, -1, -1], [0, -1, 100]),
        # Nav2's speed masks: white is 0, black is 100.
        ({"mode": Mode.SCALE, "free_thresh": 0.0, "occupied_thresh": 1.0}, [255, 204, 0], [1, 20, 99], [0, 20, 100]),
        ({"mode": Mode.SCALE, "negate": True}, [0, 128, 255], [0, 67, 100], [0, 67, 100]),
        ({"mode": Mode.RAW}, [0, 42, 100, 101, 255], [0, 42, 100, -1, -1], [0, 42, 100, -1, -1]),
        ({"mode": Mode.RAW, "negate": True}, [255, 213, 0], [0, 42, -1], [-1, -1, 0]),
    ],
)
def test_known_values_are_read_right(keys, grey, by_map_server, by_nav2):
    image = MapImage(np.array([grey], np.uint8)[..., np.newaxis])
    assert occupancy(image, record(**keys)).tolist() == [by_map_server]
    assert occupancy(image, record(**keys, rules=Rules.NAV2)).tolist() == [by_nav2]


@pytest.mark.parametrize(
    ("mode", "by_map_server", "by_nav2"),
    [
        # opaque white, grey, black; then transparent white, grey, black
        (Mode.TRINARY, [0, -1, 100, -1, -1, 100], [0, -1, 100, -1, -1, -1]),
        (Mode.SCALE, [0, 67, 100, 0, -1, 100], [0, 67, 100, -1, -1, -1]),
        (Mode.RAW, [-1, -1, 0, -1, -1, 0], [-1, -1, 0, -1, -1, 0]),
    ],
)
def test_alpha_is_averaged_by_map_server_and_unknown_in_nav2(mode, by_map_server, by_nav2):
    greys = np.array([255, 127, 0] * 2, np.uint8)
    channels = np.stack((greys, greys, greys, np.array([255] * 3 + [0] * 3, np.uint8)), axis=-1)[np.newaxis]
    assert occupancy(MapImage(channels), record(mode=mode)).tolist() == [by_map_server]
    assert occupancy(MapImage(channels), record(mode=mode, rules=Rules.NAV2)).tolist() == [by_nav2]


def test_grey_and_equal_rgb_images_give_the_same_map():
    for rules in Rules:
        for mode in Mode:
            keys = record(mode=mode, rules=rules)
            grey = occupancy(MapImage(GREYS), keys)
            assert np.array_equal(occupancy(MapImage(np.repeat(GREYS, 3, axis=2)), keys), grey)


def test_scaled_values_never_rise_with_the_grey_value():
    for rules in Rules:
        cells = occupancy(MapImage(GREYS), record(mode=Mode.SCALE, rules=rules))[0].astype(int)
        assert (np.diff(cells) <= 0).all()
        assert {0, 100} < set(cells.tolist())
