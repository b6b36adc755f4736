"""Pictures of zones: filled where they are, with a cross where they are wrong."""

import numpy as np

from ppaas.errors import ZoneFault
from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridInfo, GridMap
from robots.pictures.map_pictures import draw_zones
from tests.support.geojson import LINE, collection, feature

GRID = GridMap(np.zeros((20, 20), np.int8), GridInfo(0.1, 20, 20, Pose2D(0.0, 0.0, 0.0)))
BOW_TIE = {"type": "Polygon", "coordinates": [[[0.2, 0.2], [1.8, 1.8], [1.8, 0.2], [0.2, 1.8], [0.2, 0.2]]]}
WHITE = (255, 255, 255)


def test_the_quarters_of_a_crossed_outline_show_and_its_crossing_is_marked() -> None:
    fault = ZoneFault("a", "its outline crosses itself", (1.0, 1.0))
    image = draw_zones(GRID, collection(feature(BOW_TIE)), [fault])
    at = {place: image.picture.getpixel(image.pixels(np.array([place]))[0]) for place in ((0.4, 1.0), (1.0, 0.4))}
    assert at[0.4, 1.0] != WHITE
    assert at[1.0, 0.4] == WHITE
    assert image.picture.getpixel(image.pixels(np.array([(1.0, 1.0)]))[0]) == (255, 0, 0)


def test_features_that_are_no_zones_are_left_out() -> None:
    point = feature({"type": "Point", "coordinates": [0, 0]})
    odd = [feature(None), point, {"type": "Feature", "geometry": LINE, "properties": None}, 1]
    odd.append({"type": "Feature", "geometry": LINE, "properties": ["a"]})
    odd.append(feature({"type": "LineString", "coordinates": [[float("nan"), 0], [1, 1]]}))
    image = draw_zones(GRID, b"\xef\xbb\xbf" + collection(*odd), [ZoneFault("a", "it has no geometry")])
    assert image.picture.size == (1000, 1000)
