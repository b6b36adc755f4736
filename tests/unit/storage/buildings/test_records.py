import pytest

from ppaas.errors import NotFound
from storage.buildings import records
from tests.support.storage.records import building


def test_a_building_keeps_its_former_versions() -> None:
    record = building(versions=3)
    assert [version.number for version in (record.present, *record.former)] == [3, 2, 1]
    assert [len(record.version(number).building.floors) for number in (1, 2, 3)] == [1, 2, 3]
    assert len(record.building.floors) == 3
    with pytest.raises(NotFound, match="version of building 'hq': '4'"):
        record.version(4)


def test_the_oldest_versions_are_dropped_by_number(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(records, "MOST_FORMER", 2)
    record = building(versions=5)
    assert [version.number for version in (record.present, *record.former)] == [5, 4, 3]
    with pytest.raises(NotFound):
        record.version(2)


def test_the_oldest_versions_are_dropped_by_size(monkeypatch: pytest.MonkeyPatch) -> None:
    sizes = [len(records.json_of(version.building)) for version in building(versions=4).former]
    monkeypatch.setattr(records, "FORMER_BYTES", sizes[0] + sizes[1])
    record = building(versions=4)
    assert [version.number for version in (record.present, *record.former)] == [4, 3, 2]


def test_its_owner_and_its_readers_see_it() -> None:
    assert [building(readers=("bob",)).readable_by(name) for name in ("ann", "bob", "carl")] == [True, True, False]
    assert building(readers=("*",)).readable_by("carl")
