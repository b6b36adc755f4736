"""Times of zones: hours across midnight, days, first and last moments, and clocks that are put forward or back."""

from datetime import UTC, datetime, timedelta
from typing import Any
from zoneinfo import ZoneInfo

import msgspec
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from ppaas.errors import InvalidZones
from ppaas.zones.schedule import DAYS, Hours, is_in_force, next_limit, time_zone_of
from ppaas.zones.shapes import Polygon
from ppaas.zones.zone import NO_ZONES, KeepOut, NoStop, Zone, ZoneSet, ZonesInForce
from tests.support.world.zones import TIME_ZONES, hours, moments
from tests.support.zones import rectangle

UTC_ZONE, BERLIN = ZoneInfo("UTC"), ZoneInfo("Europe/Berlin")
DAY = 86400.0
AREA = Polygon([[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]])


def hours_of(**fields: Any) -> Hours:
    return msgspec.convert(fields, Hours)


def at(text: str, zone: ZoneInfo = UTC_ZONE, fold: int = 0) -> float:
    return datetime.fromisoformat(text).replace(tzinfo=zone, fold=fold).timestamp()


@pytest.mark.parametrize(
    ("fields", "inside", "outside"),
    [
        ({}, ["2026-03-01T00:00", "1999-12-31T23:59:59"], []),
        (
            {"from": "08:30", "to": "17:00"},
            ["2026-03-02T08:30", "2026-03-02T16:59:59"],
            ["2026-03-02T08:29:59", "2026-03-02T17:00"],
        ),
        (
            {"from": "22:00", "to": "06:00"},
            ["2026-03-02T22:00", "2026-03-02T23:59:59", "2026-03-03T00:00", "2026-03-03T05:59:59"],
            ["2026-03-02T21:59:59", "2026-03-02T06:00"],
        ),
        (
            {"days": ["fri"], "from": "22:00", "to": "06:00"},  # 2026-03-06 is a Friday
            ["2026-03-06T22:00", "2026-03-07T05:59"],
            ["2026-03-06T05:59", "2026-03-07T22:00", "2026-03-07T06:00"],
        ),
        (
            {"days": ["sun", "mon"]},
            ["2026-03-08T00:00", "2026-03-09T23:59:59"],
            ["2026-03-07T23:59:59", "2026-03-10T00:00"],
        ),
        (
            {"days": ["mon"], "from": "08:00", "to": "08:00"},
            ["2026-03-09T08:00", "2026-03-10T07:59"],
            ["2026-03-09T07:59", "2026-03-10T08:00"],
        ),
        ({"from": "24:00", "to": "01:00", "days": ["mon"]}, ["2026-03-10T00:30"], ["2026-03-09T00:30"]),
        (
            {"since": "2026-03-02T08:00:00", "until": "2026-03-04T00:00:00"},
            ["2026-03-02T08:00", "2026-03-03T23:59:59"],
            ["2026-03-02T07:59:59", "2026-03-04T00:00"],
        ),
        ({"since": "2026-03-02T08:00:00+02:00"}, ["2026-03-02T06:00"], ["2026-03-02T05:59:59"]),
        (
            {"from": "12:00", "until": "2026-03-02T13:00:00"},
            ["2026-03-02T12:59"],
            ["2026-03-02T11:59", "2026-03-02T13:00", "2026-03-03T12:00"],
        ),
    ],
)
def test_hours_contain_their_times(fields: dict[str, Any], inside: list[str], outside: list[str]) -> None:
    times = [hours_of(**fields)]
    assert [text for text in inside if not is_in_force(times, UTC_ZONE, at(text))] == []
    assert [text for text in outside if is_in_force(times, UTC_ZONE, at(text))] == []


def test_one_of_several_hours_is_enough_and_none_is_always() -> None:
    times = [hours_of(to="06:00"), hours_of(**{"from": "22:00"})]
    inside = [hour for hour in range(24) if is_in_force(times, UTC_ZONE, at(f"2026-03-02T{hour:02}:30"))]
    assert inside == [0, 1, 2, 3, 4, 5, 22, 23]
    assert is_in_force([], UTC_ZONE, 0.0)
    assert next_limit([], UTC_ZONE, 0.0) == float("inf")


def test_hours_follow_local_time_when_clocks_are_put_back() -> None:
    times = [hours_of(**{"from": "02:30", "to": "03:00"})]  # at 03:00 of 2026-10-25 it is 02:00 again
    begin = at("2026-10-25T00:00", UTC_ZONE)
    inside = [minute for minute in range(0, 180, 15) if is_in_force(times, BERLIN, begin + 60 * minute)]
    assert inside == [30, 45, 90, 105]


def test_hours_that_a_clock_skips_are_not_in_force() -> None:
    begin = at("2026-03-29T00:00", UTC_ZONE)  # at 02:00, 01:00 UTC, it is 03:00
    skipped, longer = hours_of(**{"from": "02:00", "to": "03:00"}), hours_of(**{"from": "02:30", "to": "04:00"})
    assert not any(is_in_force([skipped], BERLIN, begin + 60 * minute) for minute in range(0, 180, 15))
    inside = [minute for minute in range(0, 180, 15) if is_in_force([longer], BERLIN, begin + 60 * minute)]
    assert inside == [60, 75, 90, 105]


def test_since_is_passed_once_when_clocks_are_put_back() -> None:
    since = hours_of(since="2026-10-25T02:45:00")
    first = at("2026-10-25T00:45", UTC_ZONE)
    inside = [is_in_force([since], BERLIN, first + 60 * minute) for minute in range(-30, 120, 15)]
    assert inside == [False, False] + [True] * 8


@pytest.mark.parametrize("moment", ["0001-01-01T00:00:00", "9999-12-31T23:59:59", "0001-01-01T00:00:00+14:00"])
def test_the_first_and_the_last_moments_of_the_calendar_are_compared(moment: str) -> None:
    for zone in map(ZoneInfo, TIME_ZONES):
        early = moment.startswith("0001")
        assert is_in_force([hours_of(since=moment)], zone, 0.0) == early
        assert is_in_force([hours_of(until=moment)], zone, 0.0) != early
        assert 0.0 < next_limit([hours_of(since=moment)], zone, 0.0) <= DAY


@pytest.mark.parametrize("name", ["", "Mars", "../UTC", "/etc/passwd", "Europe", "UTC\0", "x" * 5000, "\ud800"])
def test_unknown_time_zones_are_refused(name: str) -> None:
    with pytest.raises(InvalidZones, match="there is no time zone"):
        time_zone_of(name)


def naive(one: Hours, zone: ZoneInfo, now: float) -> bool:
    """Return whether some day's hours contain a time, read off a clock on the wall."""
    utc = datetime.fromtimestamp(now, UTC)
    wall = utc.astimezone(zone).replace(tzinfo=None, fold=0)
    for moment, is_within in ((one.since, lambda then: utc >= then), (one.until, lambda then: utc < then)):
        if moment is not None and not is_within(
            (moment.replace(tzinfo=zone) if moment.tzinfo is None else moment).astimezone(UTC)
        ):
            return False
    for back in range(3):
        day = datetime(wall.year, wall.month, wall.day) - timedelta(days=back)
        begin, end = (day + timedelta(hours=int(text[:2]), minutes=int(text[3:])) for text in (one.begin, one.end))
        if one.end <= one.begin:
            end += timedelta(days=1)
        if (not one.days or DAYS[day.weekday()] in one.days) and begin <= wall < end:
            return True
    return False


zones = st.sampled_from(TIME_ZONES).map(ZoneInfo)
nows = moments.map(lambda moment: moment.replace(tzinfo=UTC).timestamp())


@given(hours(), zones, nows)
@example(Hours(begin="24:00", end="24:00"), BERLIN, at("2026-03-02T12:00"))
def test_hours_agree_with_a_naive_reading(one: Hours, zone: ZoneInfo, now: float) -> None:
    assert is_in_force([one], zone, now) == naive(one, zone, now)


@given(
    st.lists(st.lists(hours(), max_size=2), min_size=1, max_size=3),
    st.sampled_from(TIME_ZONES),
    nows | st.sampled_from([at("2026-10-24T22:00"), at("2026-03-28T23:00"), at("2026-04-04T13:00")]),
)
@example([[Hours(begin="02:30", end="03:00")]], "Europe/Berlin", at("2026-10-25T00:45"))
@example([[Hours(begin="02:30", end="04:00")]], "Europe/Berlin", at("2026-03-29T00:00"))
@example([[Hours(since=datetime(2026, 10, 25, 2, 45))]], "Europe/Berlin", at("2026-10-25T00:00"))
@example([[Hours(begin="01:45", end="02:15")]], "Australia/Lord_Howe", at("2026-04-04T13:00"))
def test_nothing_changes_before_the_next_change(times: list[list[Hours]], name: str, now: float) -> None:
    zone_set = ZoneSet([Zone(AREA, KeepOut(name=f"z{n}", times=one)) for n, one in enumerate(times)], name)
    change = zone_set.next_change(now)
    assert change > now
    if not any(times):
        assert change == float("inf")
        return
    assert change <= now + 2 * DAY
    present = zone_set.in_force(now)
    moments = [now + 900.0 * number for number in range(int((change - now) / 900.0) + 1)]
    for moment in [*(one for one in moments if one < change), change - 0.5]:
        assert zone_set.in_force(moment) == present


BOX = (0.0, 0.0, 1.0, 1.0)


def test_zones_are_the_same_object_until_others_come_into_force() -> None:
    later = KeepOut(name="later", times=[Hours(since=datetime.fromtimestamp(1_000_000.0, UTC))])
    zones = ZonesInForce(ZoneSet([rectangle(NoStop(name="always"), *BOX), rectangle(later, *BOX)]))
    before = zones.at(900_000.0)
    assert [zone.name for zone in before] == ["always"]
    assert zones.at(999_999.0) is before, "also after midnights, which change nothing"
    after = zones.at(1_000_000.0)
    assert [zone.name for zone in after] == ["always", "later"]
    assert zones.at(1_000_001.0) is after


def test_a_map_without_zones_has_none_in_force() -> None:
    assert list(ZonesInForce(NO_ZONES).at(0.0)) == []
