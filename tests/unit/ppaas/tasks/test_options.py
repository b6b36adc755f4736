"""Options of tasks: holds, and repeats at local times of day or after a period."""

from datetime import datetime
from zoneinfo import ZoneInfo

import pytest

from ppaas.errors import InvalidInput
from ppaas.tasks.options import LONGEST_HOLD, After, PlaceHold, Repeat, next_start
from ppaas.tasks.records import Task, check_task

PLACE = (1.0, 2.0, 0.0)
BERLIN = ZoneInfo("Europe/Berlin")


def berlin(text: str) -> float:
    return datetime.fromisoformat(text).replace(tzinfo=BERLIN).timestamp()


def test_times_of_day_are_local_also_when_the_clocks_are_put_back() -> None:
    daily = Repeat(at=("08:30", "17:00"), zone="Europe/Berlin")
    now = berlin("2026-10-24T09:00")
    found = []
    for _ in range(4):
        now = next_start(daily, 0.0, now)
        found.append(f"{datetime.fromtimestamp(now, BERLIN):%d %H:%M %z}")
    assert found == ["24 17:00 +0200", "25 08:30 +0100", "25 17:00 +0100", "26 08:30 +0100"]


def test_a_time_that_the_clocks_skip_is_an_hour_later() -> None:
    start = next_start(Repeat(at=("02:30",), zone="Europe/Berlin"), 0.0, berlin("2026-03-29T00:00"))
    assert f"{datetime.fromtimestamp(start, BERLIN):%d %H:%M}" == "29 03:30"


def test_midnight_at_the_end_of_a_day_belongs_to_that_day() -> None:
    start = next_start(Repeat(at=("24:00",), days=("fri",), zone="Europe/Berlin"), 0.0, berlin("2026-11-30T12:00"))
    assert f"{datetime.fromtimestamp(start, BERLIN):%a %d %H:%M}" == "Sat 05 00:00"


def test_days_of_the_week_are_kept_to() -> None:
    weekly = Repeat(at=("12:00",), days=("mon",))
    assert next_start(weekly, 0.0, datetime.fromisoformat("2026-11-30T12:00+00:00").timestamp()) == (
        datetime.fromisoformat("2026-12-07T12:00+00:00").timestamp()
    )


@pytest.mark.parametrize(("now", "expected"), [(100.0, 160.0), (160.0, 160.0), (161.0, 220.0), (500.0, 520.0)])
def test_periods_go_from_start_to_start_and_missed_runs_are_left_out(now: float, expected: float) -> None:
    assert next_start(Repeat(every=60.0), 100.0, now) == expected


@pytest.mark.parametrize(
    "options",
    [
        {"holds": (PlaceHold(confirm=True), None)},
        {"holds": (PlaceHold(),)},
        {"holds": (PlaceHold(seconds=0.0),)},
        {"holds": (PlaceHold(seconds=float("nan")),)},
        {"holds": (PlaceHold(seconds=LONGEST_HOLD + 1.0),)},
        {"weight": -1.0},
        {"weight": float("nan")},
        {"not_before": -1.0},
        {"after": (After(task="t"),) * 17},
        {"repeat": Repeat()},
        {"repeat": Repeat(at=("08:00",), every=60.0)},
        {"repeat": Repeat(every=0.5)},
        {"repeat": Repeat(at=("8:30",))},
        {"repeat": Repeat(every=60.0, days=("mon",))},
        {"repeat": Repeat(every=60.0, count=0)},
        {"repeat": Repeat(at=("08:00",), zone="Mars/Base")},
        {"repeat": Repeat(at=("08:00",) * 49)},
    ],
    ids=str,
)
def test_options_that_make_no_sense_are_refused(options: dict[str, object]) -> None:
    with pytest.raises(InvalidInput):
        check_task(Task(id="t", kind="go_to", places=(PLACE,), **options))  # type: ignore[arg-type]
