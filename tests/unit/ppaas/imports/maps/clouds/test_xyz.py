import pytest

from ppaas.errors import InvalidMap
from ppaas.imports.maps.clouds import point_cloud
from ppaas.imports.maps.clouds.xyz import read_xyz
from ppaas.imports.report import ImportReport

POINTS = [[0.5, -1.0, 2.0], [3.25, 4.5, -0.5]]
TEXTS = {
    "blanks": b"0.5 -1 2\n3.25 4.5 -5e-1\n",
    "commas and titles": b"X,Y,Z\n0.5,-1,2\n3.25,4.5,-0.5\n",
    "quoted titles": b'"x";"y";"z"\r\n0.5;-1;2\r\n3.25;4.5;-0.5\r\n',
    "comments": b"# made by hand\n//x y z\n0.5\t-1\t2\n\n3.25\t4.5\t-0.5",
    "a count of rows": b"2\n0.5 -1 2\n3.25 4.5 -0.5\n",
    "colours": b"0.5 -1 2 255 0 0\n3.25 4.5 -0.5 0 0 255\n",
    "no echo": b"nan nan nan\n0.5 -1 2\n3.25 4.5 -0.5\n",
    "a mark": b"\xef\xbb\xbf0.5 -1 2\n3.25 4.5 -0.5\n",
}


@pytest.mark.parametrize("content", TEXTS.values(), ids=list(TEXTS))
def test_rows_are_read_however_they_are_written(content):
    assert read_xyz(content, ImportReport("a.xyz")).points.tolist() == POINTS


def test_a_file_with_too_many_rows_is_refused(monkeypatch):
    monkeypatch.setattr(point_cloud, "MOST_POINTS", 3)
    with pytest.raises(InvalidMap, match="states 5 points"):
        read_xyz(b"1 2 3\n" * 4, ImportReport("a.xyz"))


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        (b"", "no row of numbers"),
        (b"1 2\n3 4\n", "x, y and z"),
        (b"1 2 3\n4 5\n", "different numbers"),
        (b"1 2 3\n4 5 six\n", "other text"),
        (b"\x00\x01\x02\x03" * 100, "no row of numbers|other text"),
        (b"1 2 3\nsix 5 4\n", "other text"),
    ],
)
def test_what_cannot_be_read_is_refused(content, reason):
    with pytest.raises(InvalidMap, match=reason):
        read_xyz(content, ImportReport("a.xyz"))
