"""Files of zones whose JSON is none: numbers that are none, features one by one, other encodings."""

import json

import pytest

from ppaas.errors import InvalidZones
from ppaas.zones.reading import read_zones, zones_of
from tests.support.geojson import SQUARE, collection, feature

NAN = float("nan")


def test_properties_that_are_nan_are_missing_as_pandas_means_them() -> None:
    """As ``GeoDataFrame.to_json(na="keep")`` writes them."""
    data = collection(feature(max_speed=NAN, robots=float("inf")))
    assert b"NaN" in data
    zones, notes = read_zones(data)
    assert zones == zones_of(collection(feature()))
    assert notes.texts() == ["NaN and infinite numbers are not JSON, and were read as null"]


def test_heights_that_are_nan_are_left_out() -> None:
    tall = {"type": "Polygon", "coordinates": [[[*place, NAN] for place in SQUARE["coordinates"][0]]]}
    assert zones_of(collection(feature(tall))) == zones_of(collection(feature()))


def test_positions_that_are_nan_are_refused_with_the_zone_and_the_place() -> None:
    wrong = {"type": "Polygon", "coordinates": [[[3, 1], [NAN, 2], [4, 4], [3, 1]]]}
    with pytest.raises(
        InvalidZones, match=r"zone 'dock' .*coordinates\[0\]\[1\]\[0\].*; it begins at \(3, 1\)"
    ) as caught:
        zones_of(collection(feature(wrong, name="dock")))
    assert [(fault.zone, fault.place) for fault in caught.value.faults] == [("dock", (3.0, 1.0))]


@pytest.mark.parametrize("begin", ["", "\x1e"])
def test_features_one_by_one_are_named(begin: str) -> None:
    data = "".join(f"{begin}{json.dumps(feature(name=name))}\n" for name in "ab")
    with pytest.raises(InvalidZones, match="features one by one"):
        zones_of(data)


@pytest.mark.parametrize(
    ("data", "text"),
    [
        (collection(feature(name="Süd")).decode().encode("latin-1"), "save the file in UTF-8"),
        (b"", "the file is empty"),
        (b'{"features": [NaN', "JSON is malformed"),
        (b'{"features": [NaN, "\\ud800"]}', "JSON is malformed"),
    ],
)
def test_other_texts_are_refused_with_what_is_wrong(data: bytes, text: str) -> None:
    with pytest.raises(InvalidZones, match="zones are not valid JSON") as caught:
        zones_of(data)
    assert text in str(caught.value)
