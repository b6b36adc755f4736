"""Coordinates of point clouds, in all their layouts."""

import numpy as np
import pytest

from ppaas.errors import InvalidInput
from ppaas.messages import decode, encode
from ppaas.messages.base.std_msgs import Header
from ppaas.messages.sensor_msgs import PointCloud2, PointField, PointFieldType
from ppaas.perception.point_cloud import coordinates_of_cloud

POINTS = np.arange(18.0).reshape(2, 3, 3)
KINDS = {"f4": PointFieldType.FLOAT32, "f8": PointFieldType.FLOAT64}


def cloud(kind="<f4", padding=4, **changed):
    layout = np.dtype([("i", "u1"), ("x", kind), ("y", kind), ("z", kind)])
    rows = np.zeros((2, 3), layout)
    for axis, name in enumerate("xyz"):
        rows[name] = POINTS[..., axis]
    data = b"".join(row.tobytes() + bytes(padding) for row in rows)
    fields = [PointField(name, layout.fields[name][1], KINDS[kind[1:]], 1) for name in "xyz"]
    given = {"fields": fields, "point_step": layout.itemsize, "row_step": 3 * layout.itemsize + padding, "data": data}
    given |= {"is_bigendian": kind[0] == ">"} | changed
    return PointCloud2(Header(), 2, 3, is_dense=True, **given)


@pytest.mark.parametrize("kind", ["<f4", ">f4", "<f8", ">f8"])
def test_coordinates_are_read_in_every_layout(kind):
    sent = decode(PointCloud2, encode(cloud(kind)))
    assert np.array_equal(np.stack(coordinates_of_cloud(sent), axis=-1), POINTS)


def test_an_empty_cloud_has_no_points():
    empty = cloud(data=b"")
    empty.width = 0
    assert [axis.size for axis in coordinates_of_cloud(empty)] == [0, 0, 0]


@pytest.mark.parametrize(
    ("wrong", "why"),
    [
        ({"fields": []}, "x, y and z, not none"),
        ({"fields": [PointField(axis, 0, PointFieldType.INT16, 1) for axis in "xyz"]}, "FLOAT32 or FLOAT64"),
        ({"fields": [PointField(axis, 99, PointFieldType.FLOAT32, 1) for axis in "xyz"]}, "exceeds the points"),
        ({"data": b"short"}, "5 bytes of data"),
        ({"row_step": 2}, "2 bytes per row"),
    ],
)
def test_broken_clouds_are_refused(wrong, why):
    with pytest.raises(InvalidInput, match=why):
        coordinates_of_cloud(cloud(**wrong))
