from pathlib import Path

import numpy as np
import pye57
import pytest

from ppaas.errors import InvalidMap
from ppaas.imports.maps.clouds import point_cloud
from ppaas.imports.maps.clouds.e57 import damaged, read_e57
from ppaas.imports.report import ImportReport

LOCAL = np.array([[1.0, 0.0, -0.5], [0.0, 2.0, 0.25]])


@pytest.fixture(scope="module")
def scans(tmp_path_factory):
    path = Path(tmp_path_factory.mktemp("e57")) / "scans.e57"
    with pye57.E57(str(path), mode="w") as file:
        columns = {f"cartesian{axis}": LOCAL[:, number].copy() for number, axis in enumerate("XYZ")}
        file.write_scan_raw(columns, translation=np.array([10.0, 20.0, 1.5]), rotation=np.array([1.0, 0, 0, 0]))
        half = np.array([0.5**0.5, 0, 0, 0.5**0.5])  # a quarter turn around z
        file.write_scan_raw(columns, translation=np.array([-3.0, 0.0, 1.5]), rotation=half)
    return path.read_bytes()


def read(content, folder):
    path = folder / "a.e57"
    path.write_bytes(content)
    with pye57.E57(str(path)) as opened:
        return read_e57(opened, len(content), ImportReport("a.e57"))


def test_scans_are_in_one_frame_with_the_places_of_their_sensors(scans, tmp_path):
    cloud = read(scans, tmp_path)
    expected = [[11, 20, 1], [10, 22, 1.75], [-3, 1, 1], [-5, 0, 1.75]]
    assert np.allclose(cloud.points, expected, atol=1e-5)
    assert [(origin.place, origin.begin, origin.end) for origin in cloud.origins] == [
        ((10.0, 20.0, 1.5), 0, 2), ((-3.0, 0.0, 1.5), 2, 4),
    ]  # fmt: skip


def test_more_points_than_the_file_can_have_are_refused(scans, tmp_path, monkeypatch):
    monkeypatch.setattr(point_cloud, "MOST_POINTS", 3)
    with pytest.raises(InvalidMap, match="states 4 points"):
        read(scans, tmp_path)


@pytest.mark.parametrize(("error", "words"), [(ValueError("first\nsecond"), "first"), (ValueError(), "ValueError()")])
def test_an_error_is_its_first_line_or_its_kind(error, words):
    assert str(damaged(error)) == f"the E57 cannot be read: {words}"
