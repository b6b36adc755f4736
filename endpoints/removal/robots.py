"""Removal of robots: their files, recordings, checkpoints, shares, and the tokens that are for them alone."""

from contextlib import suppress

from starlette.concurrency import run_in_threadpool

from endpoints.services.services import Services
from ppaas.errors import NotFound
from storage.ports import Store


async def remove_robot(services: Services, owner: str, robot: str) -> None:
    """Remove a robot with all that is of it. The robot itself is last, so an interrupted removal can be repeated.

    Raises
    ------
    NotFound
        The robot does not exist.
    """
    for token in await run_in_threadpool(_own_tokens, services.store, owner, robot):
        with suppress(NotFound):  # revoked meanwhile
            await services.accounts.revoke(owner, token)
    await services.data_folder.remove_recordings(owner, robot)
    await services.usage.in_turn(owner, _remove, services, owner, robot)
    services.shares.forget_robot(owner, robot)
    await services.data_folder.remove_recordings(owner, robot)


async def make_free(services: Services, owner: str, robot: str) -> None:
    """Remove what a former robot of an id has left; there is none of that id now."""
    await run_in_threadpool(services.store.remove_clone, owner, robot)
    await services.data_folder.remove_recordings(owner, robot)


def _own_tokens(store: Store, owner: str, robot: str) -> list[str]:
    """Return the hashes of the owner's tokens that are for one robot alone."""
    names = {robot, f"{owner}:{robot}"}
    return [
        token.hash
        for token in store.tokens(owner)
        if token.scope is not None and set(token.scope.robots) <= names
    ]  # fmt: skip


def _remove(services: Services, owner: str, robot: str) -> None:
    services.store.remove_robot(owner, robot)
    services.usage.stored.forget_urdf(owner, robot)
