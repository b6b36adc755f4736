"""LAS and LAZ files of surveys, read by laspy and lazrs."""

import io
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ppaas.distribution import install_hint
from ppaas.errors import InvalidInput, InvalidMap
from ppaas.imports.maps.clouds.point_cloud import PointCloud, check_count, check_size, offset_of
from ppaas.imports.report import ImportReport

if TYPE_CHECKING:
    import laspy

MAGIC = b"LASF"
CHUNK = 1 << 20
"""Number of points that are unpacked at once."""

GROUND, NOISE = 2, (7, 18)
"""Classes of points (LAS 1.4, tables 9 and 17)."""

_LAZ_LEAST = 0.005
"""Least size of a point in a LAZ file that is believed [bytes]; flights take 3 to 8."""

_PROJECTED = 3072
"""GeoTIFF key of the code of a projection."""


def read_las(content: bytes, report: ImportReport) -> PointCloud:
    """Read a LAS or LAZ file.

    Raises
    ------
    InvalidMap
        It is no LAS file, it is damaged, or its header states more points than it can have.
    InvalidInput
        laspy is not installed.
    """
    try:
        import laspy  # noqa: PLC0415 - needed for these files alone
    except ImportError as error:
        raise InvalidInput(f"LAS and LAZ files need laspy: {install_hint('clouds')}") from error
    try:
        with laspy.LasReader(io.BytesIO(content)) as reader:
            header = reader.header
            check_count(header.point_count, "LAS")
            size = _LAZ_LEAST if header.are_points_compressed else header.point_format.size
            check_size(int(header.point_count * size), len(content), "LAS")
            return _read(reader, report)
    except InvalidMap:
        raise
    # laspy and lazrs raise errors of many kinds for damaged files.
    except Exception as error:
        raise InvalidMap(f"the LAS cannot be read: {error}") from error


def _read(reader: "laspy.LasReader", report: ImportReport) -> PointCloud:
    header = reader.header
    offset = offset_of(np.asarray(header.mins, np.float64))
    points = np.empty((header.point_count, 3), np.float32)
    ground: NDArray[np.bool_] = np.zeros(header.point_count, np.bool_)
    count = noise = 0
    for chunk in reader.chunk_iterator(CHUNK):
        classes = np.asarray(chunk.classification)
        kept = ~np.isin(classes, NOISE)
        if "withheld" in chunk.point_format.dimension_names:
            kept &= ~np.asarray(chunk.withheld, np.bool_)
        noise += int((~kept).sum())
        used = slice(count, count + int(kept.sum()))
        for axis, raw in enumerate((chunk.X, chunk.Y, chunk.Z)):
            shift = header.offsets[axis] - offset[axis]
            points[used, axis] = np.asarray(raw)[kept] * header.scales[axis] + shift
        ground[used] = classes[kept] == GROUND
        count = used.stop
    if not count:
        raise InvalidMap("all points of the LAS are noise or withheld")
    report.taken("points", f"{count} of {header.point_count}")
    if noise:
        report.without_effect("points", f"{noise} that the file calls noise, or withholds")
    found = ground[:count] if ground.any() else None
    if found is not None:
        report.taken("classification", f"{int(found.sum())} points of the ground")
    return PointCloud(points[:count], offset, ground=found, projection=_projection(header))


def _projection(header: "laspy.LasHeader") -> str | None:
    """Return the coordinate system of a file; None without one."""
    for record in (*header.vlrs, *(header.evlrs or ())):
        if type(record).__name__ == "WktCoordinateSystemVlr" and record.string.strip("\0 "):
            return str(record.string.strip("\0 "))
        if type(record).__name__ == "GeoKeyDirectoryVlr":
            for key in record.geo_keys:
                if key.id == _PROJECTED and key.value_offset < 32767:
                    return f"EPSG:{key.value_offset}"
    return None
