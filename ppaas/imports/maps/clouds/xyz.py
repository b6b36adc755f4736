"""Point clouds as text: each row has x, y and z of a point (.xyz, .txt, .csv, .pts, .asc)."""

import re

from ppaas.errors import InvalidMap
from ppaas.imports.maps.clouds.number_text import number_table
from ppaas.imports.maps.clouds.point_cloud import PointCloud, check_count, cloud_of
from ppaas.imports.report import ImportReport

_COUNT = re.compile(rb"\A\s*\d+[ \t]*\r?\n")
"""First line of ``.pts`` files."""


def read_xyz(content: bytes, report: ImportReport) -> PointCloud:
    """Read points from text.

    Raises
    ------
    InvalidMap
        It has other text than rows of three numbers or more, or too many points.
    """
    content = _COUNT.sub(b"", content.removeprefix(b"\xef\xbb\xbf"), count=1)
    check_count(content.count(b"\n") + 1, "file")
    table = number_table(content, "file")
    if table.shape[1] < 3:
        raise InvalidMap(f"a point needs x, y and z, but the rows of the file have {table.shape[1]} numbers")
    if table.shape[1] > 3:
        report.without_effect("columns", f"{table.shape[1] - 3} behind x, y and z: a map has places alone")
    return cloud_of((table[:, 0], table[:, 1], table[:, 2]), report)
