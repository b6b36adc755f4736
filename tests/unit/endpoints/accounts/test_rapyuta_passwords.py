"""Passwords for robots that log in by the protocol of Rapyuta."""

import hashlib

import pytest

from endpoints.services.services import Services
from ppaas.errors import Conflict, InvalidInput, NotAuthenticated, NotFound, TooManyAttempts

OWN, ROBOTS = "correct horse", "battery staple"


def _digest(password: str) -> str:
    return hashlib.sha256(password.encode()).hexdigest()


@pytest.fixture
async def ann(services: Services) -> Services:
    """Return services with the user ann, whose robots have a password."""
    await services.accounts.register("ann", OWN)
    await services.accounts.rapyuta.set("ann", ROBOTS)
    return services


async def test_the_hash_of_the_password_is_a_login_whose_token_nobody_knows(ann: Services) -> None:
    user, token = await ann.accounts.rapyuta.sign_in("ann", _digest(ROBOTS).upper(), "10.0.0.1")
    assert user.id == "ann"
    assert (await ann.accounts.user_of(token)).id == "ann"


async def test_neither_the_password_nor_its_hash_is_stored(ann: Services) -> None:
    stored = ann.store.user("ann").rapyuta_hash
    assert stored.startswith("$argon2id$")
    with pytest.raises(NotAuthenticated):
        await ann.accounts.rapyuta.sign_in("ann", stored)
    with pytest.raises(NotAuthenticated):
        await ann.accounts.rapyuta.sign_in("ann", ROBOTS)


@pytest.mark.parametrize(
    ("user", "password"), [("ann", OWN), ("ann", "guess"), ("bob", ROBOTS), ("no/name", ROBOTS), ("", "")]
)
async def test_other_hashes_and_users_are_no_login(ann: Services, user: str, password: str) -> None:
    with pytest.raises(NotAuthenticated, match="wrong user or password"):
        await ann.accounts.rapyuta.sign_in(user, _digest(password))


async def test_the_password_of_robots_opens_nothing_else(ann: Services) -> None:
    for password in (ROBOTS, _digest(ROBOTS)):
        with pytest.raises(NotAuthenticated):
            await ann.accounts.login("ann", password)


async def test_a_removed_password_is_no_login(ann: Services) -> None:
    assert (await ann.accounts.rapyuta.set("ann", None)).rapyuta_hash == ""
    with pytest.raises(NotAuthenticated):
        await ann.accounts.rapyuta.sign_in("ann", _digest(ROBOTS))


async def test_the_password_of_the_user_is_not_one_for_robots_nor_the_other_way_round(ann: Services) -> None:
    with pytest.raises(InvalidInput, match="must not be that of the user"):
        await ann.accounts.rapyuta.set("ann", OWN)
    with pytest.raises(InvalidInput, match="password for robots"):
        await ann.accounts.change("ann", password=ROBOTS)
    assert await ann.accounts.login("ann", OWN)
    await ann.accounts.change("ann", password="a third password")


async def test_administrators_and_unknown_users_get_none(ann: Services) -> None:
    await ann.accounts.register("root", OWN, "admin")
    with pytest.raises(Conflict, match="administrator"):
        await ann.accounts.rapyuta.set("root", ROBOTS)
    with pytest.raises(NotFound):
        await ann.accounts.rapyuta.set("bob", ROBOTS)


async def test_failed_logins_of_robots_wait_and_do_not_end_the_wait_of_others(ann: Services) -> None:
    for _ in range(10):
        with pytest.raises(NotAuthenticated):
            await ann.accounts.sign_in("ann", "guess", "10.0.0.1")
        with pytest.raises(NotAuthenticated):
            await ann.accounts.rapyuta.sign_in("ann", _digest("guess"), "10.0.0.2")
    with pytest.raises(TooManyAttempts):
        await ann.accounts.rapyuta.sign_in("ann", _digest(ROBOTS), "10.0.0.2")
    await ann.accounts.rapyuta.sign_in("ann", _digest(ROBOTS), "10.0.0.1")
    with pytest.raises(TooManyAttempts):
        await ann.accounts.sign_in("ann", "guess", "10.0.0.1")
