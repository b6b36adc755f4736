"""The demo of people in a running cloud: a robot finds people in its scans, and the coordinator counts them."""

import json
from pathlib import Path

import pytest

from ppaas.maps.formats.map_files import save_map
from robots.client.map_files import read_map_file
from robots.demo.options import CloudAccess, DemoOptions
from robots.demo.people import follow_people
from tests.support.cloud.cloud import ADMIN_PASSWORD, RunningCloud
from tests.support.world.rooms import room

pytestmark = pytest.mark.journey


async def test_people_are_counted_and_the_demo_reports_its_figures(cloud: RunningCloud, tmp_path: Path) -> None:
    yaml, image = save_map(room(8.0, 6.0), "people-room.pgm")
    (tmp_path / "people-room.yaml").write_bytes(yaml)
    (tmp_path / "people-room.pgm").write_bytes(image)
    report = await follow_people(
        DemoOptions(
            robots=1,
            people=2,
            seconds=1.5,
            seed=5,
            map=("people-room", read_map_file(tmp_path / "people-room.yaml")),
            sensor="laser",
            on_robot=False,
        ),
        CloudAccess(cloud.url, "admin", ADMIN_PASSWORD),
    )
    assert report.map == "people-room"
    assert report.figures.seconds > 1.0
    figures = json.loads(report.to_json())
    assert list(figures) == [
        "count_error_mean", "count_exact", "identity_switches", "followed_fraction", "handovers", "flaps", "contacts",
    ]  # fmt: skip
    assert figures["contacts"] == 0
