import msgspec
import numpy as np
import pytest

from ppaas.errors import InvalidMap
from ppaas.imports.maps.household.valetudo import import_valetudo
from ppaas.imports.maps.household.valetudo_re import import_valetudo_re
from ppaas.imports.report import ImportOutcome

IMAGE = {"position": {"left": 500, "top": 490}, "dimensions": {"width": 4, "height": 3}}

NEW = {
    "pixelSize": 5,
    "size": {"x": 5120, "y": 5120},
    "layers": [
        {"type": "floor", "compressedPixels": [501, 490, 2, 501, 491, 2]},
        {"type": "wall", "compressedPixels": [500, 492, 4]},
    ],
    "entities": [
        {"type": "no_go_area", "points": [2505, 2450, 2510, 2450, 2510, 2455]},
        {"type": "virtual_wall", "points": [2505, 2450, 2505, 2455]},
        {"type": "charger_location", "points": [2505, 2450]},
    ],
}
OTHERS = {
    "forbidden_zones": [[25050, 24500, 25100, 24500, 25100, 24550]],
    "virtual_walls": [[25050, 24500, 25050, 24550]],
    "charger": [25050, 24500],
}

PIXELS = {
    "from the image": {"floor": [[1, 0], [2, 0], [1, 1], [2, 1]], "obstacle_strong": [[0, 2], [1, 2], [2, 2], [3, 2]]},
    "from the space": {
        "floor": [[501, 490], [502, 490], [501, 491], [502, 491]],
        "obstacle_weak": [[500, 492], [501, 492], [502, 492], [503, 492]],
    },
    "counted from below": {"floor": [9, 10, 5, 6], "walls": [0, 1, 2, 3]},
}


@pytest.mark.parametrize("pixels", PIXELS.values(), ids=list(PIXELS))
def test_it_is_the_same_map_as_one_of_valetudo(pixels):
    old = msgspec.json.encode({"image": IMAGE | {"pixels": pixels}, **OTHERS})
    imported, report = import_valetudo_re(old, "old.json")
    expected, _ = import_valetudo(msgspec.json.encode(NEW), "new.json")
    assert imported.grid.info == expected.grid.info
    assert np.array_equal(imported.grid.data, expected.grid.data)
    assert imported.zones == expected.zones
    assert not list(report.of(ImportOutcome.REFUSED))


def test_rooms_are_free():
    image = IMAGE | {"pixels": {"floor": [], "walls": [0]}, "segments": {"id": [3], "pixels_seg_3": [5, 6]}}
    _, report = import_valetudo_re(msgspec.json.encode({"image": image, "path": {"points": [[1, 2]]}}), "old.json")
    assert [entry.part for entry in report.entries] == [
        "layers[0] wall",
        "layers[1] segment 3",
        "grid",
        "entities[0] path",
    ]


@pytest.mark.parametrize(
    "image", [IMAGE | {"pixels": {"floor": ["a"]}}, IMAGE | {"dimensions": {}, "pixels": {"floor": [1]}}]
)
def test_an_image_that_is_not_valid_is_refused(image):
    with pytest.raises(InvalidMap, match="whole numbers"):
        import_valetudo_re(msgspec.json.encode({"image": image}), "old.json")


def test_other_json_is_refused():
    with pytest.raises(InvalidMap, match="image"):
        import_valetudo_re(b"{}", "x")
