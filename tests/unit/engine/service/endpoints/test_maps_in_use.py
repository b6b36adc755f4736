"""Changes of maps as the master passes them on to robots."""

from typing import Any

import pytest

from engine.service.endpoints.cloud import MapsInUse
from engine.specs.containers import MapVersion
from storage.records import MapFile, MapRecord, MapVersionRecord
from storage.versions import OCTOMAP, YAML


class Driver:
    """Notes changes of maps."""

    def __init__(self) -> None:
        self.changes: list[tuple[Any, ...]] = []

    def map_changed(self, version: MapVersion, number: int, *, in_space: bool) -> None:
        self.changes.append((version, number, in_space))


class Groups:
    """Notes maps whose groups are ended."""

    def __init__(self) -> None:
        self.closed: list[str] = []

    async def close_map(self, map_id: str) -> None:
        self.closed.append(map_id)


def with_files(*names: str) -> MapRecord:
    """Return a map whose current version has files of these names only."""
    files = {name: MapFile("0", 1) for name in names}
    return MapRecord("house", "ann", MapVersionRecord(7, "v7", 1000.0, "ann", files=files))


@pytest.mark.parametrize(("names", "in_space"), [((YAML,), False), ((YAML, OCTOMAP), True)])
async def test_robots_move_to_a_version_with_a_grid(names: tuple[str, ...], in_space: bool) -> None:
    driver, head = Driver(), with_files(*names)
    await MapsInUse(driver, ()).changed(head)  # type: ignore[arg-type]
    assert driver.changes == [(MapVersion("house", "v7"), 7, in_space)]


async def test_robots_stay_on_the_version_before_one_without_a_grid() -> None:
    driver = Driver()
    await MapsInUse(driver, ()).changed(with_files(OCTOMAP))  # type: ignore[arg-type]
    assert driver.changes == []


async def test_groups_of_all_kinds_on_a_removed_map_are_ended() -> None:
    people, traffic = Groups(), Groups()
    await MapsInUse(Driver(), (people, traffic)).end_groups("house")  # type: ignore[arg-type]
    assert people.closed == traffic.closed == ["house"]
