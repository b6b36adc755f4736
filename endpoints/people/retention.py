"""Retention of counts of people: when they expire, and their removal."""

import math

from ppaas.people.settings import PeopleSettings
from storage.people import HOUR, MapPeople
from storage.ports import Store


def oldest_hour(settings: PeopleSettings, now: float) -> int:
    """Return the start of the oldest hour whose counts are kept [s since the epoch]."""
    return max(0, math.floor((now - settings.retention_hours * HOUR) / HOUR) * HOUR)


def forget_expired(store: Store, people: MapPeople, now: float) -> None:
    """Remove the expired counts of a user on a map; blocks."""
    store.remove_people_counts(*people.key, before=oldest_hour(people.settings, now))


def forget_all_expired(store: Store, now: float) -> None:
    """Remove the expired counts of all users and maps; blocks."""
    for map_id in store.people_maps():
        for people in store.people_of_map(map_id):
            forget_expired(store, people, now)
