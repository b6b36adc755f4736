"""Zones of every kind at random."""

from datetime import UTC, datetime, timedelta

from hypothesis import strategies as st

from ppaas.zones.schedule import DAYS, Hours
from ppaas.zones.shapes import Geometry, LineString, MultiLineString, MultiPolygon, Polygon, Position, Ring
from ppaas.zones.zone import AnyRule, Capacity, KeepOut, Lane, NoStop, OneWay, SpeedZone, Zone, ZoneSet

TIME_ZONES = ("UTC", "Europe/Berlin", "America/New_York", "Australia/Lord_Howe", "Asia/Kathmandu", "Pacific/Apia")

_coordinate = st.integers(-400, 400).map(lambda number: number / 8.0)


@st.composite
def positions(draw: st.DrawFn) -> Position:
    return [draw(_coordinate), draw(_coordinate)]


@st.composite
def rings(draw: st.DrawFn) -> Ring:
    """Return the corners of a polygon; the last is sometimes the first again."""
    places = draw(st.lists(positions(), min_size=3, max_size=7, unique_by=tuple))
    return [*places, places[0]] if draw(st.booleans()) else places


def lines() -> st.SearchStrategy[Ring]:
    return st.lists(positions(), min_size=2, max_size=5, unique_by=tuple)


def polygons() -> st.SearchStrategy[list[Ring]]:
    """Return an outer ring and up to two holes."""
    return st.lists(rings(), min_size=1, max_size=3)


def areas() -> st.SearchStrategy[Geometry]:
    return st.builds(Polygon, polygons()) | st.builds(MultiPolygon, st.lists(polygons(), min_size=1, max_size=3))


def ways() -> st.SearchStrategy[Geometry]:
    return st.builds(LineString, lines()) | st.builds(MultiLineString, st.lists(lines(), min_size=1, max_size=3))


clocks = st.builds("{:02}:{:02}".format, st.integers(0, 23), st.sampled_from((0, 15, 30, 59))) | st.just("24:00")

_begin = datetime(2026, 1, 1)
moments = st.integers(0, 2 * 365 * 96).map(lambda quarters: _begin + timedelta(minutes=15 * quarters))
"""Local times in two years, at quarters of an hour."""


@st.composite
def hours(draw: st.DrawFn) -> Hours:
    since, until = sorted(draw(st.lists(moments, min_size=2, max_size=2, unique=True)))
    offset = UTC if draw(st.booleans()) else None
    days = draw(st.lists(st.sampled_from(DAYS), max_size=3, unique=True))
    return Hours(
        days,
        draw(clocks),
        draw(clocks),
        since.replace(tzinfo=offset) if draw(st.booleans()) else None,
        until.replace(tzinfo=offset) if draw(st.booleans()) else None,
    )


@st.composite
def rules(draw: st.DrawFn, name: str, *, lane: bool) -> AnyRule:
    times = draw(st.lists(hours(), max_size=2))
    size = draw(st.floats(0.125, 100.0))
    direction = draw(st.floats(-10.0, 10.0))
    if lane and draw(st.booleans()):
        return Lane(name=name, one_way=draw(st.booleans()))
    if lane:
        return OneWay(name=name, times=times, width=size, strict=draw(st.booleans()))
    one = draw(st.booleans())
    kinds: list[AnyRule] = [
        KeepOut(name=name, times=times),
        SpeedZone(name=name, times=times, max_speed=size if one else None, percent=None if one else size),
        OneWay(name=name, times=times, direction=direction, strict=one),
        NoStop(name=name, times=times),
        Capacity(name=name, times=times, robots=draw(st.integers(1, 1000))),
    ]
    return draw(st.sampled_from(kinds))


@st.composite
def zone_sets(draw: st.DrawFn) -> ZoneSet:
    names = draw(st.lists(st.text(min_size=1, max_size=64), max_size=5, unique=True))
    zones = []
    for name in names:
        lane = draw(st.booleans())
        zones.append(Zone(draw(ways() if lane else areas()), draw(rules(name, lane=lane))))
    return ZoneSet(zones, draw(st.sampled_from(TIME_ZONES)))
