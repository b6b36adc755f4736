from engine.agent.master_session import DENIED, LEASE, SILENT, MasterLease
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


def test_lease_holds_while_heartbeats_are_answered() -> None:
    lease = MasterLease(time := Time())
    assert all(beating(lease, time, 20, answered=True))
    assert lease.holds()


def test_lease_ends_before_the_master_gives_the_machine_up() -> None:
    lease = MasterLease(time := Time())
    beating(lease, time, 3, answered=True)
    sent = time.now
    while lease.holds():
        time.now += 0.01
    assert time.now - sent <= LEASE + 0.02 < MISSED * BEAT_PERIOD


def test_lease_counts_from_the_sending_of_the_heartbeat() -> None:
    lease = MasterLease(time := Time())
    lease.beat()
    time.now += LEASE + 0.1
    lease.answered()
    assert not lease.holds()


def test_suspended_agent_has_no_lease_until_the_next_answer() -> None:
    lease = MasterLease(time := Time())
    beating(lease, time, 3, answered=True)
    time.now += 60.0
    assert not lease.holds()
    beating(lease, time, 1, answered=True)
    assert lease.holds()


def test_master_is_given_up_for_missed_answers_not_for_own_suspension() -> None:
    lease = MasterLease(time := Time())
    assert all(beating(lease, time, 3, answered=True))
    time.now += 60.0
    assert lease.beat()
    assert beating(lease, time, MISSED + 1, answered=False)[-1] is False


def test_unsolicited_answer_does_not_extend_the_lease() -> None:
    lease = MasterLease(time := Time())
    time.now += LEASE
    lease.answered()
    assert not lease.holds()


def test_an_answer_of_a_master_that_does_not_lead_shows_only_that_it_runs() -> None:
    lease = MasterLease(time := Time())
    for _ in range(2 * MISSED):
        assert all(beating(lease, time, 1, answered=False)), "it runs"
        lease.answered(leads=False)
    assert not lease.holds()
    beating(lease, time, 1, answered=True)
    assert lease.holds()


def test_unanswered_heartbeats_are_counted() -> None:
    lease = MasterLease(time := Time())
    beating(lease, time, 3, answered=True)
    assert lease.unanswered == 0
    beating(lease, time, 2, answered=False)
    assert lease.unanswered == 2


def test_nobody_leads_once_a_master_has_answered_so_for_long() -> None:
    lease = MasterLease(time := Time())
    for _ in range(DENIED):
        assert not lease.nobody_leads(), "another one may be found"
        beating(lease, time, 1, answered=False)
        lease.answered(leads=False)
    assert lease.nobody_leads()
    beating(lease, time, SILENT, answered=False)
    assert not lease.nobody_leads(), "it is silent: another one may lead"
    lease.answered(leads=False)
    assert lease.nobody_leads()
    lease.answered()
    assert not lease.nobody_leads(), "it leads"


def test_time_in_which_the_agent_was_stopped_shows_nothing() -> None:
    lease = MasterLease(time := Time())
    beating(lease, time, 1, answered=False)
    lease.answered(leads=False)
    time.now += 60.0
    assert not lease.nobody_leads()
