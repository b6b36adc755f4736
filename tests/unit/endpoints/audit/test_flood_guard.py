"""Folding of similar events.

Who may flood: a stranger with logins or tokens that are wrong, from one address or many; a user with actions that are
refused; a user who repeats an action on one object.
"""

from endpoints.audit.event import AuditEvent
from endpoints.audit.flood_guard import MAX_WINDOWS, OF_STRANGERS, PER_KEY, WINDOW, FloodGuard
from ppaas.clock import ManualClock


def refused(user: str | None = "ann", token: str | None = "0123456789ab", **fields: object) -> AuditEvent:
    return AuditEvent(action="remove_map", outcome="refused", user=user, token=token, address="10.0.0.1", **fields)  # type: ignore[arg-type]


def admitted(guard: FloodGuard, events: list[AuditEvent]) -> int:
    return sum(len(guard.admit(event)) for event in events)


def test_similar_events_beyond_a_number_are_folded_into_one() -> None:
    clock = ManualClock()
    guard = FloodGuard(clock)
    assert admitted(guard, [refused(object=f"maps/{n}") for n in range(PER_KEY + 5)]) == PER_KEY
    clock.advance(WINDOW)
    [folded] = guard.ended()
    assert (folded.repeats, folded.object) == (5, f"maps/{PER_KEY + 4}")
    assert admitted(guard, [refused()]) == 1


def test_actions_that_were_performed_on_different_objects_are_all_kept() -> None:
    guard = FloodGuard(ManualClock())
    done = [AuditEvent(action="put_robot", user="ann", token="0", object=f"robots/{n}") for n in range(100)]
    assert admitted(guard, done) == 100


def test_another_user_and_another_action_are_not_folded_with_these() -> None:
    guard = FloodGuard(ManualClock())
    admitted(guard, [refused()] * 100)
    assert admitted(guard, [refused("bob"), AuditEvent(action="put_robot", user="ann", token="0")]) == 2


def test_strangers_at_many_addresses_are_folded_together() -> None:
    guard = FloodGuard(ManualClock())
    logins = [
        AuditEvent(action="log_in", outcome="refused", user=f"u{n}", address=f"10.0.{n % 100}.1") for n in range(1000)
    ]
    assert admitted(guard, logins) == OF_STRANGERS


def test_strangers_at_one_address_are_folded_whatever_names_they_give() -> None:
    guard = FloodGuard(ManualClock())
    logins = [AuditEvent(action="log_in", outcome="refused", user=f"u{n}", address="10.0.0.1") for n in range(100)]
    assert admitted(guard, logins) == PER_KEY


def test_the_memory_of_the_guard_is_bounded() -> None:
    guard = FloodGuard(ManualClock())
    for number in range(MAX_WINDOWS + 100):
        guard.admit(AuditEvent(action="put_robot", user="ann", token="0", object=f"robots/{number}"))
    assert len(guard._windows) == MAX_WINDOWS
