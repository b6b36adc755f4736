"""Parts of the people bench that measure the torso detector: simulated and recorded images, and the link."""

import asyncio
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from benchmarks.people import detector, legs
from benchmarks.people.bandwidth import CountingProxy
from benchmarks.people.options import PeopleOptions
from benchmarks.people.torso.recorded import FOCAL, recorded_images
from ppaas.errors import InvalidInput
from robots.sim.depth.camera import DepthCameraModel
from robots.sim.depth.shapes import box, shapes_of
from tests.support.world.depth_images import image_of

KINECT = DepthCameraModel(
    field_of_view=(2.0 * np.arctan(320.0 / FOCAL), 2.0 * np.arctan(240.0 / FOCAL)), z=1.2, pitch=0.3
)
"""Camera of the recorded images, which looks down."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder of data with two recorded images of a table."""
    data = tmp_path_factory.mktemp("data")
    (data / "depth").mkdir()
    table = shapes_of([], [box((2.5, 0.0, 0.7), (0.5, 0.6, 0.02))])
    for k in range(2):
        image = image_of(table, model=KINECT, seed=k)
        Image.fromarray(image).save(data / "depth" / f"{k}.depth.png")
        np.savetxt(data / "depth" / f"{k}.pose.txt", np.eye(4))
    return data


def test_the_part_reports_figures_of_simulated_and_recorded_images(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(detector, "QUICK_WORLDS", 1)
    monkeypatch.setattr(detector, "IMAGES", 3)
    found = detector.measure(PeopleOptions(data=folder, quick=True))
    figures = {figure.name: figure for figure in found.figures}
    assert figures["precision, 640×480"].limit == figures["recall, 640×480"].limit == 0.97
    assert figures["CPU time of an image, 640×480"].limit == 8.0
    assert 0.0 < figures["recall, 640×480"].value <= 1.0
    assert figures["detections of nobody in a recorded image"].value == 0.0
    assert [row["size"] for row in found.rows] == ["640×480", "320×240"]
    assert found.results[-1] == {"recorded_images": 2, "wrong": 0}


def test_the_mount_of_recorded_images_is_found_by_level_surfaces(folder: Path) -> None:
    _, _, mount = next(recorded_images(folder / "depth"))
    assert mount[2, 3] == pytest.approx(1.2, abs=0.05)
    assert np.arcsin(-mount[2, 2]) == pytest.approx(0.3, abs=0.03)


def test_folders_without_images_or_with_broken_ones_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InvalidInput, match="no depth images"):
        next(recorded_images(tmp_path))
    (tmp_path / "1.depth.png").write_bytes(b"no image")
    with pytest.raises(InvalidInput, match="is not a depth image"):
        next(recorded_images(tmp_path))


async def test_the_proxy_counts_the_bytes_of_each_direction() -> None:
    async def answer(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        await reader.readexactly(5)
        writer.write(b"no")
        writer.close()

    server = await asyncio.start_server(answer, "127.0.0.1", 0)
    proxy = CountingProxy("127.0.0.1", server.sockets[0].getsockname()[1])
    async with server, proxy.serve() as url:
        reader, writer = await asyncio.open_connection("127.0.0.1", int(url.rpartition(":")[2]))
        writer.write(b"hello")
        assert await reader.read() == b"no"
        writer.close()
    assert (proxy.up, proxy.down) == (5, 2)


def test_the_part_reports_recall_by_distance_and_precision(monkeypatch: pytest.MonkeyPatch) -> None:
    for name, value in (("SECONDS", 2.5), ("OFFICE", (14.0, 11.0)), ("PEOPLE", 14)):
        monkeypatch.setattr(legs, name, value)
    figures, rows, [counts] = legs.measure(PeopleOptions(quick=True, seed=2))
    assert [figure.unit for figure in figures] == ["", "", "m", "ms"]
    assert [row["distance"] for row in rows] == ["0–1 m", "1–2 m", "2–3 m", "3–4 m"]
    people = sum(int(row["people"]) for row in rows)
    assert people > 0
    assert people == sum(number for name, number in counts.items() if name.startswith(("seen", "missed")))
    assert figures[0].value > 0.5
