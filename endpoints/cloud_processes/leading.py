"""Leadership of a cloud process: waits for the lease of the master, and ends the process when it has lost it."""

import argparse
import asyncio
import contextlib
import logging
import os
import signal
import socket
import sys
from collections.abc import Awaitable, Callable
from typing import NoReturn

from endpoints.listeners import listen
from engine.bootstrap import CloudConfig
from engine.leadership.leadership import MASTER, Leadership, holder_of
from engine.local.kept_process import SpareProcesses
from engine.processes.background import cancel_all
from engine.protocols.address import parse_host_port
from engine.remote.replica import LAST, MACHINES
from ppaas.errors import Conflict, InvalidInput, Unavailable
from ppaas.log_lines import escaped, refusal
from storage.ports import LeaseStore
from storage.urls.opening import open_store

logger = logging.getLogger(__name__)

RETRY = 1.0
"""Time between two attempts to reach a master with a secret [s]."""

REPLACED = 1
"""Exit status of a process that another one has replaced."""


async def take_the_lead(
    arguments: argparse.Namespace, config: CloudConfig, spares: SpareProcesses, stack: contextlib.AsyncExitStack
) -> Leadership:
    """Return the leadership of this process once it leads; ``stack`` gives it up.

    A standby starts its endpoints as ``spares``; otherwise their start would be part of the take-over.

    Raises
    ------
    Unavailable
        Another cloud leads with this store and this process is no standby, or the store cannot be used.
    """
    standby = arguments.standby is not None
    store = await asyncio.to_thread(open_store, config.store)
    stack.callback(store.close)
    leadership = Leadership(store, holder_of(arguments.data))
    stack.push_async_callback(leadership.release)
    async with contextlib.AsyncExitStack() as meanwhile:
        if standby:
            await asyncio.to_thread(_get_ready, arguments)
            founds = arguments.standby_secret_file is not None and await _founds(arguments, store)
            # Two that begin a cloud at once have no common files: the other one ends, and is started again.
            standby = not founds
        if standby:
            await _copy_files(arguments, config.listen_machines, meanwhile)
            await spares.start(arguments.endpoints)
            logger.info("standing by: this process leads once no other one does")
        await leadership.acquire(standby=standby)
    if standby:
        former = f"in place of {leadership.former}" if leadership.former else "which no other process led"
        logger.info("this process leads the cloud now, %s, in epoch %d", former, leadership.epoch)
    watching = asyncio.create_task(_end_when_lost(leadership))
    stack.callback(watching.cancel)
    return leadership


async def _founds(arguments: argparse.Namespace, store: LeaseStore) -> bool:
    """Join the masters as a standby by a secret; return whether there is no cloud yet, so that this process leads."""
    from engine.remote.authority import STANDBY  # noqa: PLC0415 - as below
    from engine.remote.masters import KnownMasters  # noqa: PLC0415
    from engine.remote.membership import join_by_secret  # noqa: PLC0415
    from engine.remote.standbys import FOLDER  # noqa: PLC0415

    if not arguments.master:
        raise InvalidInput("--standby-secret-file needs --master HOST:PORT, where other masters listen for machines")
    addresses, said = tuple(map(parse_host_port, arguments.master)), ""
    name = f"{socket.gethostname().partition('.')[0][:56]}{STANDBY}"
    while not arguments.standby and not (arguments.data / LAST).exists():
        try:
            await join_by_secret(arguments.data / FOLDER, arguments.standby_secret_file, name, addresses)
            break
        except Unavailable as error:
            if (await asyncio.to_thread(store.lease, MASTER)).epoch == 0:
                logger.info("no process has led this cloud yet: this one does")
                return True
            if str(error) != said:
                said = str(error)
                logger.warning("waiting for a master that has the files of the cloud: %s", said)
        await asyncio.sleep(RETRY)
    if (arguments.data / LAST).exists():
        KnownMasters(arguments.data / MACHINES).note(map(str, addresses))
    return False


async def _copy_files(
    arguments: argparse.Namespace, listen_machines: str | None, stack: contextlib.AsyncExitStack
) -> None:
    """Copy the leader's files for its machines of other hosts; wait for them unless earlier ones are here."""
    # Imported here, because a process that is no standby does not need cryptography.
    from engine.remote.machines import ADDRESS  # noqa: PLC0415
    from engine.remote.standbys import StandbyLink, membership_of  # noqa: PLC0415

    (arguments.data / MACHINES / ADDRESS).unlink(missing_ok=True)  # tickets are made by the leader alone
    if listen_machines is None:
        if arguments.standby:
            raise InvalidInput("the ticket of a standby is for machines of other hosts: give --listen-machines as well")
        return
    address = parse_host_port(listen_machines)
    if address.port == 0:
        raise InvalidInput("a standby needs --listen-machines with a port other than 0, which machines can be told")
    membership = await membership_of(arguments.data, arguments.standby, socket.gethostname())
    if membership is None:
        logger.info("no other process of this cloud has stood by yet, so there are no files to copy")
        return
    link = StandbyLink(arguments.data, membership, address)
    copying = asyncio.create_task(link.run())
    stack.push_async_callback(cancel_all, (copying,))
    if not (arguments.data / LAST).exists():
        logger.info("waiting for the files of the leader at %s", membership.cloud)
        await link.complete.wait()


def _get_ready(arguments: argparse.Namespace) -> None:
    """Find out what would fail when this process leads."""
    for port in (arguments.port, arguments.rapyuta, arguments.foxglove):
        for listener in listen(arguments.host, port) if port is not None else ():
            listener.close()


async def _end_when_lost(leadership: Leadership) -> None:
    try:
        await leadership.lost()
    except asyncio.CancelledError:
        raise
    except BaseException:  # a fault of ours: nothing renews the lease any more
        logger.exception("the lease of the master is not renewed any more")
    _end(leadership.epoch)


# -- hand-over ---------------------------------------------------------------------------------------------------------

SUCCESSION, LOOK = 5.0, 0.1
"""Time within which a standby takes the lease of a process that hands over, and the period of looks [s]."""

ARRIVAL = 3.0
"""Time for which the endpoints of this host serve on while machines and endpoints register with the next leader [s]."""


def asked_to_hand_over() -> asyncio.Event:
    """Return an event that SIGUSR1 sets."""
    asked = asyncio.Event()
    asyncio.get_running_loop().add_signal_handler(signal.SIGUSR1, asked.set)
    return asked


async def hand_over(
    leadership: Leadership,
    store: LeaseStore,
    end_machine: Callable[[], Awaitable[None]],
    end_endpoints: Callable[[], Awaitable[None]],
) -> NoReturn:
    """Let a standby lead, and end this process: other machines are not dismissed, and keep their containers.

    Parameters
    ----------
    leadership : Leadership
        Leadership of this process.
    store : LeaseStore
        Store of the lease.
    end_machine : callable
        Ends the machine of this host, whose containers would act beside those that replace them.
    end_endpoints : callable
        Ends the endpoints of this host; their clients connect to others.
    """
    logger.info("this process hands the cloud over to a standby")
    await end_machine()
    await leadership.release()
    until = asyncio.get_running_loop().time() + SUCCESSION
    while not (taken := await _is_taken(store)) and asyncio.get_running_loop().time() < until:  # noqa: ASYNC110
        await asyncio.sleep(LOOK)
    if not taken:
        logger.error("no standby leads after %g s: start one, or this process again", SUCCESSION)
    await asyncio.sleep(ARRIVAL)
    await end_endpoints()
    logging.shutdown()
    os._exit(0 if taken else REPLACED)


async def _is_taken(store: LeaseStore) -> bool:
    try:
        return bool((await asyncio.to_thread(store.lease, MASTER)).holder)
    except Unavailable as error:
        logger.debug("the lease of the master cannot be read: %s", error)
        return False


def _end(epoch: int) -> NoReturn:
    """End this process at once, as if it had been killed.

    What a clean end does, such as dismissing machines or storing checkpoints, would harm the process that leads now.
    """
    error = Conflict(
        f"another process leads this cloud now, after epoch {epoch} of this one: machines and robots continue there; "
        "start this process again with --standby"
    )
    logging.shutdown()
    sys.stderr.write(refusal(error.slug, escaped(str(error))))
    sys.stderr.flush()
    os._exit(REPLACED)
