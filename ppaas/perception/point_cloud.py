"""Coordinates of the points of ``sensor_msgs/PointCloud2``."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidInput
from ppaas.messages.sensor_msgs import PointCloud2, PointField, PointFieldType

MOST_POINTS = 1 << 24
"""Largest number of points of a cloud."""

_NUMBERS = {PointFieldType.FLOAT32: "f4", PointFieldType.FLOAT64: "f8"}
_AXES = ("x", "y", "z")


def coordinates_of_cloud(cloud: PointCloud2) -> list[NDArray[np.floating]]:
    """Return the coordinates x, y and z of a cloud in the frame of its sensor, each (height, width), as views [m].

    Raises
    ------
    InvalidInput
        It has no fields x, y and z of float32 or float64, or fewer bytes than its size requires.
    """
    order = ">" if cloud.is_bigendian else "<"
    kinds = [(field, _kind_of(field, cloud, order)) for field in _coordinates(cloud.fields)]
    count = cloud.width * cloud.height
    if not count:
        return [np.empty((0, 0), np.float32)] * 3
    needed = cloud.row_step * (cloud.height - 1) + cloud.point_step * cloud.width
    short = cloud.row_step < cloud.point_step * cloud.width or len(cloud.data) < needed
    if min(cloud.width, cloud.height) < 1 or count > MOST_POINTS or short:
        raise InvalidInput(
            f"a cloud of {cloud.width}×{cloud.height} points, of {cloud.point_step} bytes each and {cloud.row_step} "
            f"bytes per row, cannot have {len(cloud.data)} bytes of data; at most {MOST_POINTS} points are allowed"
        )
    shape, steps = (cloud.height, cloud.width), (cloud.row_step, cloud.point_step)
    return [np.ndarray(shape, kind, cloud.data, field.offset, steps) for field, kind in kinds]


def _coordinates(fields: Sequence[PointField]) -> list[PointField]:
    by_name = {field.name: field for field in fields}
    if not all(axis in by_name for axis in _AXES):
        raise InvalidInput(f"a point cloud must have the fields x, y and z, not {', '.join(by_name) or 'none'}")
    return [by_name[axis] for axis in _AXES]


def _kind_of(field: PointField, cloud: PointCloud2, order: str) -> np.dtype[np.floating]:
    numbers = _NUMBERS.get(field.datatype)  # type: ignore[call-overload]
    if numbers is None:
        raise InvalidInput(
            f"the field {field.name!r} of a point cloud must be FLOAT32 or FLOAT64, not {field.datatype}"
        )
    kind: np.dtype[np.floating] = np.dtype(order + numbers)
    if not 0 <= field.offset <= cloud.point_step - kind.itemsize:
        raise InvalidInput(
            f"the field {field.name!r} at byte {field.offset} exceeds the points of {cloud.point_step} bytes"
        )
    return kind
