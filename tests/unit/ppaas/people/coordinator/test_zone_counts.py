"""Counts of people per hour and zone."""

from ppaas.people.coordinator.zone_counts import HOUR, ZoneCounts
from ppaas.people.settings import CountingZone, PeopleSettings

DOOR = CountingZone("door", [(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0)])
SETTINGS = PeopleSettings(zones=[DOOR], history=True, retention_hours=2.0)
NOON = 472_222 * HOUR


def counted(counts: ZoneCounts, since: int = 0) -> list[tuple[str, int, int]]:
    return [(each.zone, (each.hour - NOON) // HOUR, each.people) for each in counts.since(since)]


def test_a_person_counts_once_in_an_hour_however_often_seen() -> None:
    counts = ZoneCounts(SETTINGS)
    for second in range(3):
        counts.add({1: (1.0, 1.0), 2: (5.0, 5.0)}, NOON + second)
    assert counted(counts) == [("", 0, 2), ("door", 0, 1)]


def test_a_person_counts_again_in_the_next_hour() -> None:
    counts = ZoneCounts(SETTINGS)
    counts.add({1: (1.0, 1.0)}, NOON)
    counts.add({1: (5.0, 5.0)}, NOON + HOUR)
    assert counted(counts) == [("", 0, 1), ("door", 0, 1), ("", 1, 1)]
    assert counted(counts, NOON + HOUR) == [("", 1, 1)]


def test_counts_are_forgotten_after_their_retention() -> None:
    counts = ZoneCounts(SETTINGS)
    for hour in range(5):
        counts.add({1: (5.0, 5.0)}, NOON + hour * HOUR)
    assert [hour for _, hour, _ in counted(counts)] == [2, 3, 4]


def test_two_ids_that_are_one_person_count_once() -> None:
    counts = ZoneCounts(SETTINGS)
    counts.add({1: (1.0, 1.0), 2: (1.0, 1.0)}, NOON)
    counts.merge(1, 2)
    assert counted(counts) == [("", 0, 1), ("door", 0, 1)]


def test_history_that_is_switched_off_is_forgotten() -> None:
    counts = ZoneCounts(SETTINGS)
    counts.add({1: (1.0, 1.0)}, NOON)
    counts.configure(PeopleSettings())
    assert counted(counts) == []
