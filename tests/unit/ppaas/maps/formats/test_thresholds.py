"""Occupancy of pixels, by the rules of map_server and of Nav2: against slow twins and known values."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from ppaas.maps.formats.image import MapImage
from ppaas.maps.formats.map_files import occupancy
from ppaas.maps.formats.map_yaml import MapYaml, Mode, Rules
from tests.reference.maps import map_image as twin

THRESHOLDS = st.one_of(st.sampled_from([0.0, 0.196, 0.25, 0.65, 1.0, 51 / 255, 204 / 255]), st.floats(0.0, 1.0))
PIXELS = st.integers(1, 4).flatmap(
    lambda n: hnp.arrays(
        np.uint8,
        st.tuples(st.integers(1, 6), st.integers(1, 6), st.just(3 if n == 2 else n)),
        elements=st.one_of(st.sampled_from([0, 51, 89, 90, 100, 101, 204, 205, 206, 254, 255]), st.integers(0, 255)),
    )
)
GREYS = np.arange(256, dtype=np.uint8)[np.newaxis, :, np.newaxis]


def record(**keys) -> MapYaml:
    return MapYaml(**({"image": "a.png", "resolution": 0.05, "origin": (0.0, 0.0, 0.0)} | keys))


@given(PIXELS, st.sampled_from(Mode), st.booleans(), THRESHOLDS, THRESHOLDS, st.sampled_from(Rules))
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
