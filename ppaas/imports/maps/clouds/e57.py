"""E57 files of laser scanners (ASTM E2807), read by libE57 through pye57. Each scan has the place of its sensor."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidMap
from ppaas.imports.maps.clouds.point_cloud import PointCloud, ScanOrigin, check_count, check_size, offset_of
from ppaas.imports.report import ImportReport

MAGIC = b"ASTM-E57"


def read_e57(opened: Any, size: int, report: ImportReport) -> PointCloud:
    """Read all scans of an E57 file.

    Parameters
    ----------
    opened : E57
        The file, opened by pye57: libE57 reads files alone.
    size : int
        Its size [bytes].
    report : ImportReport

    Raises
    ------
    InvalidMap
        It is damaged, or its scans state too many points.
    """
    try:
        return _read(opened, size, report)
    except InvalidMap:
        raise
    # libE57 raises an error of C++ of a kind that it does not export.
    except Exception as error:
        raise damaged(error) from error


def damaged(error: Exception) -> InvalidMap:
    """Return the error for a file that libE57 cannot read; its own has many lines."""
    return InvalidMap(f"the E57 cannot be read: {(str(error).strip() or repr(error)).splitlines()[0]:.120}")


def _read(opened: Any, size: int, report: ImportReport) -> PointCloud:
    headers = [opened.get_header(number) for number in range(opened.scan_count)]
    total = sum(header.point_count for header in headers)
    check_count(total, "E57")
    check_size(total // 8, size, "E57")  # a point that repeats the one before takes some bits
    points, offset, begin = np.empty((total, 3), np.float32), None, 0
    origins = []
    for number, header in enumerate(headers):
        scan = _scan(opened, number)
        if offset is None:
            offset = offset_of(scan.min(axis=0)) if len(scan) else np.zeros(3)
        points[begin : begin + len(scan)] = scan - offset
        if header.has_pose() and len(scan):
            x, y, z = (np.asarray(header.translation, np.float64) - offset).tolist()
            origins.append(ScanOrigin((x, y, z), begin, begin + len(scan)))
        begin += len(scan)
        report.taken(f"data3D[{number}]", f"{len(scan)} of {header.point_count} points")
    if not begin or offset is None:
        raise InvalidMap("the scans of the E57 have no valid points")
    return PointCloud(points[:begin], offset, tuple(origins))


def _scan(opened: Any, number: int) -> NDArray[np.float64]:
    """Return the valid points of a scan in the frame of the file, (n, 3)."""
    data = opened.read_scan(number, ignore_missing_fields=True)
    scan = np.stack([data["cartesianX"], data["cartesianY"], data["cartesianZ"]], axis=1)
    return np.asarray(scan[np.isfinite(scan).all(axis=1)])
