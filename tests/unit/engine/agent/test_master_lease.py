from engine.agent.master_lease import LEASE, MasterLease
from engine.processes.heartbeats import BEAT_PERIOD, MISSED


class Time:
    def __init__(self) -> None:
        self.now = 100.0

    def __call__(self) -> float:
        return self.now


def beating(lease: MasterLease, time: Time, beats: int, *, answered: bool) -> list[bool]:
    """Send heartbeats, one each period; return for each whether the master still answers."""
    found = []
    for _ in range(beats):
        time.now += BEAT_PERIOD
        found.append(lease.beat())
        if answered:
            lease.answered()
    return found


def test_it_holds_while_beats_are_answered() -> None:
    lease = MasterLease(time := Time())
    assert all(beating(lease, time, 20, answered=True))
    assert lease.holds()


def test_it_ends_before_the_master_can_have_given_the_machine_up() -> None:
    lease = MasterLease(time := Time())
    beating(lease, time, 3, answered=True)
    sent = time.now
    while lease.holds():
        time.now += 0.01
    assert time.now - sent <= LEASE + 0.02 < MISSED * BEAT_PERIOD


def test_it_counts_from_when_the_beat_was_sent_not_from_when_its_answer_came() -> None:
    lease = MasterLease(time := Time())
    lease.beat()
    time.now += LEASE + 0.1
    lease.answered()
    assert not lease.holds()


def test_who_stood_still_has_no_lease_until_it_is_answered_again() -> None:
    lease = MasterLease(time := Time())
    beating(lease, time, 3, answered=True)
    time.now += 60.0
    assert not lease.holds()
    beating(lease, time, 1, answered=True)
    assert lease.holds()


def test_a_master_that_does_not_answer_is_given_up_but_not_for_our_own_standing_still() -> None:
    lease = MasterLease(time := Time())
    assert all(beating(lease, time, 3, answered=True))
    time.now += 60.0
    assert lease.beat()
    assert beating(lease, time, MISSED + 1, answered=False)[-1] is False


def test_an_answer_that_was_not_asked_for_changes_nothing() -> None:
    lease = MasterLease(time := Time())
    time.now += LEASE
    lease.answered()
    assert not lease.holds()
