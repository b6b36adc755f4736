"""A run and its result, for tests."""

from benchmarks.people.runs.job import PeopleJob, PeopleResult
from tests.support.world.rooms import room

JOB = PeopleJob("room", room(8.0, 6.0), robots=2, people=3, minutes=5.0)

RESULT = PeopleResult(
    "room", 2, 3, "paper", 0, count_error_mean=0.02, count_exact=0.98, identity_switches=3, followed_fraction=0.97,
    handovers=2, flaps=0, contacts=0, seen=1.5, ghosts=0.1, hota=0.8, mota=0.9, simulated=300.0, taken=100.0,
    cycle_p99=0.004,
)  # fmt: skip
