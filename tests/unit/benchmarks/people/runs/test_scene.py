"""A short run of robots among people, with each part real but the detector."""

import pytest

from benchmarks.people.runs.job import PeopleJob, PeopleResult
from benchmarks.people.runs.picture import Tracks, draw
from benchmarks.people.runs.run import run
from tests.support.world.rooms import room

ROBOTS, PEOPLE, SECONDS = 2, 5, 5.0


@pytest.fixture(scope="module")
def short() -> tuple[PeopleJob, PeopleResult, Tracks]:
    """Return a run in a room, its result and its tracks."""
    job = PeopleJob("room", room(8.0, 6.0), ROBOTS, PEOPLE, SECONDS / 60.0, detections="truth", seed=2)
    tracks = Tracks()
    return job, run(job, tracks.watch), tracks


def test_people_in_view_are_counted_and_followed(short: tuple[PeopleJob, PeopleResult, Tracks]) -> None:
    _, result, tracks = short
    assert result.simulated == pytest.approx(SECONDS, abs=0.1)
    assert result.seen > 0.5
    assert result.count_exact > 0.7
    assert (result.contacts, result.flaps) == (0, 0)
    assert set(tracks.robots) == {"r0", "r1"}
    assert len(tracks.people) == PEOPLE
    assert tracks.identities


def test_a_run_is_drawn_with_its_robots_and_identities(short: tuple[PeopleJob, PeopleResult, Tracks]) -> None:
    job, _, tracks = short
    (axes,) = draw(job.grid, tracks).axes
    texts = {text.get_text() for text in axes.texts}
    assert {"r0", "r1"} <= texts
    assert {str(identity) for identity in tracks.identities} <= texts
