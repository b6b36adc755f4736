"""Maps that are floors of one building are one area; others are areas by themselves."""

from engine.control.tasks.areas import REREAD, TaskArea, TaskAreas
from ppaas.buildings.building import Building, Floor
from storage.buildings.records import BuildingRecord, BuildingVersion, building_with_map
from storage.memory.store import MemoryStore


def record(owner: str, *maps: str, readers: tuple[str, ...] = ()) -> BuildingRecord:
    floors = tuple(Floor(name=f"{owner} {number}", map=name) for number, name in enumerate(maps))
    version = BuildingVersion(number=1, building=Building(floors=floors), author=owner, created=1.0)
    return BuildingRecord(user=owner, id="b", present=version, readers=readers)


async def test_the_floors_of_a_building_are_one_area() -> None:
    store = MemoryStore()
    areas = TaskAreas(store)
    await areas.read(0.0)
    assert areas.of(("ann", "m1")) == TaskArea("ann", (("", "m1"),))
    assert not areas.of(("ann", "m1")).has_floors
    store.put_building(record("bob", "m1", "m2", readers=("ann",)))
    await areas.read(REREAD - 1.0)
    assert not areas.of(("ann", "m1")).has_floors
    await areas.read(REREAD)
    area = areas.of(("ann", "m1"))
    assert area == areas.of(("ann", "m2")) == TaskArea("ann", (("bob 0", "m1"), ("bob 1", "m2")))
    assert (area.has_floors, area.map_on("bob 1"), area.groups) == (True, "m2", [("ann", "m1"), ("ann", "m2")])
    assert areas.of(("eve", "m1")) == TaskArea("eve", (("", "m1"),))


def test_an_own_building_comes_first() -> None:
    records = [record("aaa", "m1", readers=("*",)), record("ann", "m1"), record("bob", "m1", readers=("*",))]
    owners = {user: building_with_map(records, user, "m1") for user in ("ann", "bob", "eve")}
    assert {user: None if found is None else found.user for user, found in owners.items()} == {
        "ann": "ann", "bob": "bob", "eve": "aaa",
    }  # fmt: skip
    assert building_with_map(records, "ann", "m9") is None
