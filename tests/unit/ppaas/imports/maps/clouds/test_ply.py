import struct

import pytest

from ppaas.errors import InvalidMap
from ppaas.imports.maps.clouds.ply import read_ply
from ppaas.imports.report import ImportReport

POINTS = [(0.5, -1.0, 2.0), (3.25, 4.5, -0.5)]


def header(form, count=2, *, before="", after="", properties="property float z\nproperty uchar red\n"):
    return (
        f"ply\nformat {form} 1.0\ncomment made by hand\n{before}element vertex {count}\nproperty double y\n"
        f"property float x\n{properties}{after}end_header\n"
    ).encode()


def binary(order):
    return b"".join(struct.pack(f"{order}dffB", y, x, z, 9) for x, y, z in POINTS)


CAMERA = "element camera 1\nproperty int width\nproperty short height\n"
FACES = "element face 1\nproperty list uchar int vertex_indices\n"
TEXT = "".join(f"{y} {x} {z} 9\n" for x, y, z in POINTS).encode()


@pytest.mark.parametrize(
    "content",
    [
        header("ascii", after=FACES) + TEXT + b"3 0 1 1\n",
        header("ascii", before=CAMERA) + b"640 480\n" + TEXT,
        header("ascii").replace(b"\n", b"\r\n") + TEXT.replace(b"\n", b"\r\n"),
        header("binary_little_endian", after=FACES) + binary("<") + struct.pack("<B3i", 3, 0, 1, 1),
        header("binary_big_endian", before=CAMERA) + struct.pack(">ih", 640, 480) + binary(">"),
    ],
)
def test_vertices_are_read_in_all_forms(content):
    assert read_ply(content, ImportReport("a.ply")).points.tolist() == [list(point) for point in POINTS]


def test_what_is_no_vertex_is_reported():
    report = ImportReport("a.ply")
    read_ply(header("ascii", after=FACES) + TEXT + b"3 0 1 1\n", report)
    assert [entry.part for entry in report.entries] == ["properties", "element face", "points"]


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        (b"plx", "not valid"),
        (header("binary_middle_endian"), "not valid"),
        (header("ascii", -1), "negative"),
        (header("ascii", 10**11), "states 100000000000 points"),
        (header("binary_little_endian") + binary("<")[:-1], "truncated"),
        (header("ascii", 3) + TEXT, "has 2 rows"),
        (header("ascii", properties="property list uchar float z\n") + TEXT, "no vertices with x, y and z"),
        (header("ascii", before=FACES) + TEXT, "lists in or before"),
        (header("ascii") + TEXT.replace(b"4.5", b"four"), "other text"),
        (header("ascii") + TEXT.replace(b"-1.0", b"one"), "1 rows are none|other text"),
        (b"ply\nformat ascii 1.0\nelement face 1\nproperty float x\nend_header\n1\n", "no vertices"),
    ],
)
def test_what_cannot_be_read_is_refused(content, reason):
    with pytest.raises(InvalidMap, match=reason):
        read_ply(content, ImportReport("a.ply"))
