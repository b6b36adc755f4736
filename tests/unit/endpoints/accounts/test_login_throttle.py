"""Tests of the throttle of logins.

Members of the kind, guessing a password: one user from one address; one user from many addresses; many users from one
address; the old password of a change. None may lock the owner out.
"""

import pytest

from endpoints.accounts.fair_queue import Origin
from endpoints.accounts.login_throttle import ADDRESS, FORGET, MAX_COUNTED, USER, USER_AT_ADDRESS, LoginThrottle
from ppaas.clock import ManualClock
from ppaas.errors import TooManyAttempts

HOME, AWAY = "10.0.0.1", "10.9.9.9"


@pytest.fixture
def clock() -> ManualClock:
    return ManualClock()


@pytest.fixture
def throttle(clock: ManualClock) -> LoginThrottle:
    return LoginThrottle(clock)


def fail(throttle: LoginThrottle, user: str, address: str, times: int = 1) -> None:
    for _ in range(times):
        throttle.failed(Origin(user, address))


def wait_of(throttle: LoginThrottle, user: str, address: str) -> float:
    try:
        throttle.admit(user, address)
    except TooManyAttempts as error:
        assert error.retry_after is not None
        return error.retry_after
    return 0.0


def test_a_few_failures_have_no_wait(throttle: LoginThrottle) -> None:
    fail(throttle, "ann", HOME, USER_AT_ADDRESS.failures - 1)
    assert throttle.admit("ann", HOME) == Origin("ann", HOME, known=False)


def test_each_failure_beyond_doubles_the_wait_up_to_a_limit(throttle: LoginThrottle, clock: ManualClock) -> None:
    fail(throttle, "ann", HOME, USER_AT_ADDRESS.failures)
    waits = []
    for _ in range(8):
        waits.append(wait_of(throttle, "ann", HOME))
        clock.advance(waits[-1])
        assert wait_of(throttle, "ann", HOME) == 0.0
        fail(throttle, "ann", HOME)
    assert waits == pytest.approx([1, 2, 4, 8, 16, 32, 60, 60])


def test_attempts_during_the_wait_do_not_extend_it(throttle: LoginThrottle, clock: ManualClock) -> None:
    fail(throttle, "ann", HOME, USER_AT_ADDRESS.failures)
    for _ in range(8):
        assert wait_of(throttle, "ann", HOME) > 0.0
        clock.advance(0.125)
    assert wait_of(throttle, "ann", HOME) == 0.0


def test_a_success_and_time_forget_failures(throttle: LoginThrottle, clock: ManualClock) -> None:
    fail(throttle, "ann", HOME, USER_AT_ADDRESS.failures)
    throttle.succeeded(Origin("ann", HOME))
    assert wait_of(throttle, "ann", HOME) == 0.0
    fail(throttle, "bob", HOME, 30)
    clock.advance(FORGET)
    assert wait_of(throttle, "bob", HOME) == 0.0


def test_guesses_from_many_addresses_do_not_lock_the_owner_out(throttle: LoginThrottle) -> None:
    throttle.succeeded(Origin("ann", HOME))
    for number in range(USER.failures):
        fail(throttle, "ann", f"10.1.0.{number}")
    assert wait_of(throttle, "ann", "10.1.0.200") > 0.0
    assert throttle.admit("ann", HOME).known


def test_guesses_of_many_users_at_one_address_delay_new_users_there_only(throttle: LoginThrottle) -> None:
    throttle.succeeded(Origin("ann", HOME))
    for number in range(ADDRESS.failures):
        fail(throttle, f"user{number}", HOME)
    assert wait_of(throttle, "bob", HOME) > 0.0
    assert wait_of(throttle, "bob", AWAY) == 0.0
    assert wait_of(throttle, "ann", HOME) == 0.0


def test_memory_is_bounded(throttle: LoginThrottle) -> None:
    for number in range(MAX_COUNTED + 10):
        fail(throttle, f"u{number}", f"a{number}")
        throttle.succeeded(Origin(f"u{number}", f"a{number}"))
    sizes = (throttle._of_pair._failures, throttle._of_user._failures, throttle._of_address._failures, throttle._known)
    assert all(len(counted) <= MAX_COUNTED for counted in sizes)
