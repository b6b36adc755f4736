import io
import struct

import laspy
import numpy as np
import pytest
from laspy.vlrs.known import WktCoordinateSystemVlr

from ppaas.errors import InvalidMap
from ppaas.imports.maps.clouds.las import read_las
from ppaas.imports.report import ImportReport

POINTS = np.array([[690010.25, 5330020.5, 412.75], [690011.0, 5330021.0, 413.0], [690012.0, 5330022.0, 500.0]])
WKT = 'PROJCS["site",GEOGCS["WGS 84",DATUM["WGS_1984",SPHEROID["WGS 84",6378137,298.257223563]]]]'


def survey(compressed, *, version="1.4", form=6, wkt=None, classes=(2, 1, 7)):
    header = laspy.LasHeader(point_format=form, version=version)
    header.offsets, header.scales = [690000.0, 5330000.0, 0.0], [0.001] * 3
    if wkt is not None:
        header.vlrs.append(WktCoordinateSystemVlr(wkt))
    file = laspy.LasData(header)
    file.x, file.y, file.z = POINTS.T
    file.classification = np.array(classes, np.uint8)
    written = io.BytesIO()
    file.write(written, do_compress=compressed)
    return written.getvalue()


@pytest.mark.parametrize("compressed", [False, True])
@pytest.mark.parametrize(("version", "form"), [("1.2", 3), ("1.4", 6)])
def test_points_are_read_without_noise(compressed, version, form):
    report = ImportReport("a.laz")
    cloud = read_las(survey(compressed, version=version, form=form), report)
    assert np.allclose(cloud.points + cloud.offset, POINTS[:2], atol=2e-3)
    assert cloud.offset[:2].tolist() == [690000.0, 5330000.0]
    assert cloud.ground is not None and cloud.ground.tolist() == [True, False]
    assert [entry.text for entry in report.entries][:2] == ["2 of 3", "1 that the file calls noise, or withholds"]


def test_the_coordinate_system_is_that_of_the_file():
    assert read_las(survey(False, wkt=WKT), ImportReport("a")).projection == WKT
    assert read_las(survey(False), ImportReport("a")).projection is None


def test_withheld_points_are_left_out():
    header = laspy.LasHeader(point_format=6, version="1.4")
    file = laspy.LasData(header)
    file.x, file.y, file.z = np.arange(9.0).reshape(3, 3)
    file.withheld = np.array([0, 1, 0])
    written = io.BytesIO()
    file.write(written)
    assert len(read_las(written.getvalue(), ImportReport("a")).points) == 2


def bomb():
    """Return a LAZ file whose header states many more points than it has."""
    content = bytearray(survey(True))
    content[107:111] = struct.pack("<I", 0)
    content[247:255] = struct.pack("<Q", 45_000_000)
    return bytes(content)


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        (bomb(), "truncated"),
        (survey(False)[:-10], "truncated|cannot be read"),
        (survey(True)[:-40], "cannot be read"),
        (b"LASF" + bytes(400), "cannot be read|no points"),
        (survey(False, classes=(7, 18, 7)), "noise or withheld"),
    ],
)
def test_what_cannot_be_read_is_refused(content, reason):
    with pytest.raises(InvalidMap, match=reason):
        read_las(content, ImportReport("a.laz"))
