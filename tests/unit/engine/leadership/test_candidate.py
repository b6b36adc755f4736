"""One candidate, step by step."""

import pytest

from engine.leadership.candidate import Candidate, Change, Read, Role, Timing
from storage.records import Lease

TIMING = Timing(renew=0.5, look=0.25, validity=2.5, patience=3.0)
OTHERS = Lease("master", "b", 4, 7)
LATE = 100.0


def waiting(lease: Lease, now: float = 0.0) -> Candidate:
    """Return a candidate that has seen a lease."""
    candidate = Candidate("master", "a", now, TIMING)
    assert candidate.next(now) == Read("master")
    candidate.was_read(lease, now)
    return candidate


def leading(now: float = 0.0) -> Candidate:
    """Return a candidate that began to lead at a time."""
    candidate = waiting(Lease("master"), now)
    assert candidate.next(now) == Change(Lease("master", "a", 1), Lease("master"))
    candidate.was_changed(now, done=True)
    return candidate


def renewal(beat: int) -> Change:
    return Change(Lease("master", "a", 1, beat), Lease("master", "a", 1, beat - 1))


@pytest.mark.parametrize("left", [Lease("master"), Lease("master", "", 4, 9), Lease("master", "a", 4, 9)])
def test_a_lease_of_nobody_or_of_an_earlier_process_is_taken_at_once(left: Lease) -> None:
    candidate = waiting(left)
    assert candidate.next(0.0) == Change(Lease("master", "a", left.epoch + 1), left)
    assert candidate.next(0.0) is None, "one request at a time"
    candidate.was_changed(0.1, done=True)
    assert (candidate.role, candidate.held.epoch, candidate.former) == (Role.LEADING, left.epoch + 1, "")


def test_a_lease_that_does_not_change_is_taken_after_the_patience() -> None:
    candidate = waiting(OTHERS)
    for look in range(1, 12):
        now = look * TIMING.look
        assert candidate.next(now - 0.01) is None
        assert candidate.next(now) == Read("master")
        candidate.was_read(OTHERS, now)
    assert candidate.next(2.99) is None
    assert candidate.next(3.0) == Change(Lease("master", "a", 5), OTHERS)
    candidate.was_changed(3.1, done=True)
    assert (candidate.held, candidate.former, candidate.rival) == (Lease("master", "a", 5), "b", "")
    assert candidate.leads(5.4) and not candidate.leads(5.5), "from when it was asked for"


def test_a_lease_that_changes_is_waited_for_and_its_holder_is_a_rival() -> None:
    candidate = waiting(OTHERS)
    assert candidate.next(2.9) == Read("master")
    candidate.was_read(Lease("master", "b", 4, 8), 2.9)
    assert candidate.rival == "b"
    assert candidate.next(3.2) == Read("master")


def test_a_standby_that_was_stopped_asks_for_what_it_has_seen_and_is_refused() -> None:
    candidate = waiting(OTHERS)
    assert candidate.next(LATE) == Read("master")
    candidate.was_read(Lease("master", "b", 4, 200), LATE)
    assert candidate.next(LATE) is None


def test_a_leader_renews_and_leads_from_when_it_asked() -> None:
    candidate = leading()
    assert candidate.next(0.49) is None
    assert candidate.next(0.5) == renewal(1)
    candidate.was_changed(2.0, done=True)
    assert candidate.leads(2.9) and not candidate.leads(3.0)
    assert candidate.next(2.0) == renewal(2), "the answer came late"


def test_a_leader_whose_answer_was_lost_finds_its_renewal() -> None:
    candidate = leading()
    candidate.next(0.5)
    candidate.has_failed(1.0)
    assert candidate.next(1.25) == Read("master")
    candidate.was_read(Lease("master", "a", 1, 1), 1.3)
    assert candidate.next(1.3) == renewal(2)
    candidate.was_changed(1.4, done=True)
    assert candidate.leads(3.7)


def test_a_leader_without_answers_leads_no_more_and_leads_again_if_nobody_took_over() -> None:
    candidate = leading()
    candidate.next(0.5)
    candidate.has_failed(5.5)
    assert (candidate.leads(2.4), candidate.leads(2.5), candidate.role) == (True, False, Role.LEADING)
    assert candidate.next(6.0) == Read("master")
    candidate.was_read(Lease("master", "a", 1), 6.1)
    assert not candidate.leads(6.1), "reading renews nothing"
    assert candidate.next(6.1) == renewal(1)
    candidate.was_changed(6.2, done=True)
    assert candidate.leads(6.2)


def test_a_leader_that_wakes_up_finds_out_that_it_was_replaced() -> None:
    candidate = leading()
    assert not candidate.leads(LATE)
    assert candidate.next(LATE) == renewal(1)
    candidate.was_changed(LATE, done=False)
    assert candidate.next(LATE) == Read("master")
    candidate.was_read(Lease("master", "b", 2, 9), LATE)
    assert (candidate.role, candidate.is_over, candidate.next(LATE + 9)) == (Role.REPLACED, True, None)


def test_a_leader_is_replaced_by_a_later_epoch_that_it_hears_of() -> None:
    candidate = leading()
    candidate.next(0.5)
    for epoch in (0, 1):
        candidate.heard_of(epoch)
        assert candidate.leads(0.5)
    candidate.heard_of(2)
    assert candidate.role is Role.REPLACED
    candidate.was_changed(0.6, done=True)
    assert not candidate.leads(0.6), "an answer that comes later changes nothing"


def test_a_leader_releases_its_lease_once() -> None:
    candidate = leading()
    candidate.next(0.5)
    assert candidate.release() is None, "a renewal is under way"
    candidate.was_changed(0.6, done=True)
    assert candidate.release() == Change(Lease("master", "", 1, 2), Lease("master", "a", 1, 1))
    assert (candidate.release(), candidate.leads(0.6), candidate.role) == (None, False, Role.RELEASED)


def test_a_standby_whose_attempt_was_lost_looks_again() -> None:
    candidate = waiting(Lease("master"))
    candidate.next(0.0)
    candidate.has_failed(1.0)
    assert candidate.next(1.25) == Read("master")
    candidate.was_read(Lease("master", "a", 1), 1.3)
    assert candidate.next(1.3) == Change(Lease("master", "a", 2), Lease("master", "a", 1))


def test_an_answer_without_a_request_is_an_error() -> None:
    with pytest.raises(ValueError, match="under way"):
        waiting(OTHERS).was_changed(0.0, done=True)
