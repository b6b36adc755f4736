"""Agent of another host: ``python -m engine.remote.agent FOLDER``, with ``MachineOptions`` as JSON on standard input.

It requests the settings of the cluster from its cloud and runs the machine's agent until the cloud closes the
connection. It repeats this until SIGTERM or Ctrl-C, so the machine returns to a cloud that was restarted or unreachable.
"""

import asyncio
import logging
import os
import signal
import sys
import tempfile
from pathlib import Path

import msgspec
import uvloop

from engine.agent.agent import run, until_told
from engine.agent.components import dial_master
from engine.agent.config import AgentConfig
from engine.agent.master_redial import Master
from engine.processes.instances import folder_of, instance_name, sweep_stale
from engine.processes.run_dir import keep_temporary_files_in, remove_folder
from engine.remote.cluster_settings import ClusterSettings
from engine.remote.machines import check_reachable
from engine.remote.membership import Membership, membership_in
from ppaas import __version__
from ppaas.clock import monotonic
from ppaas.errors import Conflict, PPaaSError, Unavailable
from storage.urls.opening import check_exists

logger = logging.getLogger(__name__)

RETRIES = (0.25, 0.5, 1.0, 2.0, 5.0)
"""Seconds before the first, second … try in a row to reach a cloud that is away; a steady while begins the row anew."""

STEADY = 30.0


class MachineOptions(msgspec.Struct, frozen=True):
    """What the machine gives: CPUs, all without a number, what it is like; how long the cloud may be away [s]."""

    cores: int | None = None
    labels: dict[str, str] = {}
    patience: float = sys.float_info.max


async def stay(membership: Membership, options: MachineOptions) -> None:
    """Be a machine of the cloud until SIGTERM.

    Raises
    ------
    Conflict
        The cloud runs another release of this program: whoever starts this anew may have installed that.
    InvalidInput, NotFound
        The stores of the cloud cannot be reached from here.
    Unavailable
        The cloud was away for longer than the options allow.
    """
    base = Path(tempfile.gettempdir())
    sweep_stale(base)  # of a life before that was ended by force
    folder = folder_of(instance_name(), base)
    folder.mkdir(mode=0o700)
    keep_temporary_files_in(folder)  # for as long as this process lives: the fork server listens there
    try:
        await _stay(membership, options, folder / "run")
    finally:
        remove_folder(folder)


async def _stay(membership: Membership, options: MachineOptions, run_dir: Path) -> None:
    told, tries, heard = asyncio.Event(), 0, monotonic()
    while True:
        began = monotonic()
        if await _live(membership, options, run_dir, told):
            heard = monotonic()
        if told.is_set():
            return
        if monotonic() - heard > options.patience:
            raise Unavailable(f"the cloud of machine {membership.machine} was away for {options.patience:g} s")
        tries = 0 if monotonic() - began > STEADY else tries + 1
        with until_told(told):
            await asyncio.sleep(RETRIES[min(tries, len(RETRIES)) - 1])
        if told.is_set():
            return


async def _live(membership: Membership, options: MachineOptions, run_dir: Path, told: asyncio.Event) -> bool:
    """Be the agent once; return whether the cloud was there, and hung up."""
    config: AgentConfig | None = None
    try:
        with until_told(told):
            config = config_of(membership, options, await membership.settings(), run_dir)
        return config is not None and await run(config, told, lambda: dial_again(membership, options, config))
    except Unavailable as error:
        logger.warning("machine %s is not in its cloud: %s", membership.machine, error)
        return False


def config_of(membership: Membership, options: MachineOptions, terms: ClusterSettings, run_dir: Path) -> AgentConfig:
    """Return what the agent is told.

    Raises
    ------
    Conflict
        The cloud runs another release of this program.
    InvalidInput, NotFound
        The stores of the cloud cannot be reached from here.
    """
    if terms.release != __version__:
        raise Conflict(
            f"the cloud runs release {terms.release or '(untold)'} and machine {membership.machine} {__version__}: "
            "install the cloud's, and start the machine again"
        )
    for url in (terms.store, terms.map_store):
        check_reachable(url)
        check_exists(url)  # a path that is not shared would become an empty store
    run_dir.mkdir(mode=0o700, exist_ok=True)
    return AgentConfig(
        machine=membership.machine,
        control=str(membership.cloud),
        secret="",  # the certificate says who it is
        run_dir=str(run_dir),
        cloud=terms.cloud,
        store=terms.store,
        map_store=terms.map_store,
        outbox=str(membership.folder / "outbox.sqlite"),
        cores=options.cores,
        labels=options.labels,
        peering=membership.peering(terms),
        identity=str(membership.folder),
        runtime=terms.runs.runtime,
        image=terms.runs.image,
        allowed=terms.runs.allowed,
        adopt_within=terms.runs.adopt_within,
    )


async def dial_again(membership: Membership, options: MachineOptions, config: AgentConfig) -> Master:
    """Dial the cloud as the machine that already runs as it was told.

    Raises
    ------
    Conflict
        The cloud was started with other terms, or runs another release.
    Unavailable
        It is away.
    """
    now = config_of(membership, options, await membership.settings(), Path(config.run_dir))
    if msgspec.structs.replace(now, cloud=config.cloud) != config:
        raise Conflict("the cloud was started with other terms: the machine joins anew")
    return await dial_master(config)


def main() -> None:
    """Run until SIGTERM, or Ctrl-C, which is the same here."""
    logging.basicConfig(level=logging.INFO, format="%(levelname)s agent %(name)s: %(message)s")
    signal.signal(signal.SIGINT, lambda *_: os.kill(os.getpid(), signal.SIGTERM))
    options = msgspec.json.decode(sys.stdin.buffer.read(), type=MachineOptions)
    try:
        uvloop.run(stay(membership_in(Path(sys.argv[1])), options))
    except PPaaSError as error:
        logger.error("the machine cannot run: %s", error)
        sys.exit(1)


if __name__ == "__main__":
    main()
