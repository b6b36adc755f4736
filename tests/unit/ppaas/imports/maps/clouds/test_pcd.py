import struct

import lzf
import numpy as np
import pytest

from ppaas.errors import InvalidMap
from ppaas.imports.maps.clouds import point_cloud
from ppaas.imports.maps.clouds.pcd import read_pcd
from ppaas.imports.report import ImportOutcome, ImportReport

POINTS = np.array([[0.5, -1.0, 2.0], [3.25, 4.5, -0.5], [np.nan, 0.0, 0.0]])
# An intensity and padding of two bytes, whose name is repeated, as PCL writes them.
FIELDS = [
    ("intensity", "F", 4, 1),
    ("_", "U", 1, 2),
    ("x", "F", 4, 1),
    ("_", "U", 1, 3),
    ("y", "F", 8, 1),
    ("z", "F", 4, 1),
]


def header(encoding, count=3, viewpoint="0 0 0 1 0 0 0", fields=FIELDS):
    names, kinds, sizes, counts = zip(*fields, strict=True)
    lines = [
        "# .PCD v0.7", "VERSION 0.7", f"FIELDS {' '.join(names)}", f"SIZE {' '.join(map(str, sizes))}",
        f"TYPE {' '.join(kinds)}", f"COUNT {' '.join(map(str, counts))}", f"WIDTH {count}", "HEIGHT 1",
        f"VIEWPOINT {viewpoint}", f"POINTS {count}", f"DATA {encoding}", "",
    ]  # fmt: skip
    return "\n".join(lines).encode()


def columns(points):
    count = len(points)
    return [
        np.ones(count, "<f4").tobytes(), bytes(2 * count), points[:, 0].astype("<f4").tobytes(), bytes(3 * count),
        points[:, 1].astype("<f8").tobytes(), points[:, 2].astype("<f4").tobytes(),
    ]  # fmt: skip


def binary(points=POINTS):
    rows = b"".join(struct.pack("<f2sf3sdf", 1.0, b"", x, b"", y, z) for x, y, z in points.tolist())
    return header("binary", len(points)) + rows


def compressed(points=POINTS):
    body = b"".join(columns(points))
    packed = lzf.compress(body, 2 * len(body) + 100)
    return header("binary_compressed", len(points)) + struct.pack("<II", len(packed), len(body)) + packed


def ascii_text(points=POINTS):
    return header("ascii", len(points)) + "".join(f"1 0 0 {x} 0 0 0 {y} {z}\n" for x, y, z in points).encode()


@pytest.mark.parametrize("content", [binary(), compressed(), ascii_text()], ids=["binary", "compressed", "ascii"])
def test_points_are_read_in_all_encodings(content):
    report = ImportReport("a.pcd")
    cloud = read_pcd(content, report)
    assert cloud.points.tolist() == POINTS[:2].tolist()
    assert [(entry.outcome, entry.part) for entry in report.entries] == [
        (ImportOutcome.NO_EFFECT, "fields"), (ImportOutcome.NO_EFFECT, "points"), (ImportOutcome.TAKEN, "points"),
    ]  # fmt: skip
    assert cloud.origins == ()


def test_a_viewpoint_is_the_place_of_the_sensor():
    content = header("ascii", 1, "1 2 0.5 1 0 0 0", [(name, "F", 4, 1) for name in "xyz"]) + b"4 5 6\n"
    [origin] = read_pcd(content, ImportReport("a")).origins
    assert (origin.place, origin.begin, origin.end) == ((1.0, 2.0, 0.5), 0, 1)


@pytest.mark.parametrize("viewpoint", ["1 2", "nan 0 0 1 0 0 0"])
def test_a_viewpoint_that_is_none_is_refused_alone(viewpoint):
    report = ImportReport("a")
    fields = [(name, "F", 4, 1) for name in "xyz"]
    cloud = read_pcd(header("ascii", 1, viewpoint, fields) + b"4 5 6\n", report)
    assert (len(cloud.points), cloud.origins) == (1, ())
    assert [entry.part for entry in report.of(ImportOutcome.REFUSED)] == ["VIEWPOINT"]


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        (b"VERSION 0.7\n", "DATA is missing"),
        (header("zipped"), "unknown DATA"),
        (header("binary", 0), "no points"),
        (header("binary", 10**12), "states 1000000000000 points"),
        (binary()[:-1], "truncated"),
        (compressed()[:-1], "truncated"),
        (header("binary_compressed") + struct.pack("<II", 3, 75) + b"\xff\xff\xff", "damaged"),
        (header("binary_compressed", 40_000_000) + struct.pack("<II", 3, 25 * 40_000_000) + b"abc", "compressed bytes"),
        (header("ascii", 3) + b"1 0 0 1 0 0 0 1 1\n", "truncated|states 3 points"),
        (header("ascii", 1) + b"one two three four five six seven\n", "other text|has 0"),
        (header("ascii", 1, fields=[("a", "F", 4, 1)]) + b"1\n", "no field 'x'"),
        (header("ascii", 1, fields=[("x", "F", 3, 1)]), "not valid"),
        (header("ascii", 1, fields=[("x", "Q", 4, 1)]), "not valid"),
        (binary(np.full((2, 3), np.nan)), "not finite"),
    ],
)
def test_what_cannot_be_read_is_refused(content, reason):
    with pytest.raises(InvalidMap, match=reason):
        read_pcd(content, ImportReport("a.pcd"))


def test_coordinates_of_the_earth_become_relative():
    content = (
        header("ascii", 2, fields=[(name, "F", 8, 1) for name in "xyz"])
        + b"691234.567 5334321.25 1\n691235 5334322 2\n"
    )
    cloud = read_pcd(content, ImportReport("a"))
    assert cloud.offset.tolist() == [691200.0, 5334300.0, 0.0]
    assert np.allclose(cloud.points + cloud.offset, [[691234.567, 5334321.25, 1], [691235, 5334322, 2]], atol=1e-3)
    assert point_cloud.FAR < 691200.0
