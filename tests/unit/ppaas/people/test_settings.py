"""Settings of people: what is refused, and with which words."""

import msgspec
import pytest

from ppaas.errors import InvalidInput
from ppaas.people.names import hears_coordinator, tracks_people
from ppaas.people.settings import CountingZone, PeopleSettings, settings_of

SQUARE = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0)]


def test_settings_are_read_as_they_were_written() -> None:
    settings = PeopleSettings(
        "named", [3], 2, {"3": "Ada"}, [CountingZone("hall", SQUARE)], history=True, retention_hours=2.0
    )
    assert settings_of(msgspec.json.encode(settings)) == settings


def test_history_is_off_by_default() -> None:
    assert not settings_of("{}").history


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("{", "not valid JSON"),
        ('{"rul": "nearest"}', "rul"),
        ('{"followed_at_once": -1}', "followed_at_once must be from 0"),
        ('{"retention_hours": 0}', "retention_hours must be above 0"),
        ('{"zones": [{"name": "", "corners": []}]}', "from 1 to 64 characters"),
        ('{"zones": [{"name": "a", "corners": [[0, 0], [1, 1]]}]}', "from 3 to 100 corners"),
        ('{"zones": [{"name": "a", "corners": [[0,0],[1,0],[1,1]]}, {"name": "a", "corners": [[0,0],[1,0],[1,1]]}]}',
         "different names"),
    ],
)  # fmt: skip
def test_invalid_settings_are_refused_with_a_reason(text: str, words: str) -> None:
    with pytest.raises(InvalidInput, match=words):
        settings_of(text)


def test_corners_must_be_finite() -> None:
    with pytest.raises(InvalidInput, match="must be finite"):
        PeopleSettings(zones=[CountingZone("a", [*SQUARE, (float("nan"), 0.0)])])


@pytest.mark.parametrize("name", ["torso_detector", "leg_detector", "people_tracker"])
def test_a_robot_with_a_detector_or_a_tracker_tracks_people(name: str) -> None:
    assert tracks_people({name: {}}) and hears_coordinator({name: {}})


def test_a_robot_that_only_follows_hears_the_coordinator() -> None:
    assert hears_coordinator({"follow_person": {}}) and not tracks_people({"follow_person": {}})
    assert not hears_coordinator({"amcl": {}})
