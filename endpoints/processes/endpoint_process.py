"""Endpoint process: composes the web server and the engine's part, and runs both until it is stopped."""

import asyncio
import contextlib
import logging
import signal
from pathlib import Path

import uvloop

from endpoints.accounts.accounts import Accounts
from endpoints.accounts.usage import Usage
from endpoints.audit.cloud_audit import cloud_audit
from endpoints.http.front_settings import FrontSettings
from endpoints.http.open_files import connection_table, raise_file_limit
from endpoints.http.tls import ServerTls
from endpoints.listeners import listen
from endpoints.processes.config import EndpointConfig
from endpoints.processes.shared_logins import MasterLogins
from endpoints.processes.shared_turns import MasterTurns
from endpoints.services.caches import Caches
from endpoints.services.robot_facts import RobotFacts
from endpoints.services.services import Services
from endpoints.web import Web
from engine.endpoint.endpoint import Endpoint, MasterAddress
from engine.endpoint.link_listener import MachineAccess
from engine.leadership.leadership import MASTER
from engine.protocols.address import UnixAddress, parse_host_port
from engine.service.endpoints.server import SOCKET
from ppaas.errors import PPaaSError
from storage.disk_space.reserve import DiskReserve
from storage.ports import Store
from storage.recordings.folder import RecordingsFolder
from storage.urls.opening import open_map_store, open_store

logger = logging.getLogger(__name__)


def run(config: EndpointConfig) -> None:
    """Serve until SIGTERM, or until there was no master for some time.

    Raises
    ------
    Conflict, NotPermitted
        The master refuses this endpoint.
    Unavailable
        The port or a store cannot be used.
    """
    uvloop.run(_serve(config))


async def _serve(config: EndpointConfig) -> None:
    stop = asyncio.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        asyncio.get_running_loop().add_signal_handler(number, stop.set)
    async with contextlib.AsyncExitStack() as stack:
        web, endpoint, store = await _composed(config, stack)

        async def replaced() -> bool:
            return await _is_led_by_another(store, config.holder)

        works = [
            asyncio.create_task(_listen(config, web, stack)),
            asyncio.create_task(endpoint.run(config.orphaned, replaced)),
            asyncio.create_task(_until(stop)),
        ]
        try:
            done, _ = await asyncio.wait(works, return_when=asyncio.FIRST_COMPLETED)
            for work in done:
                work.result()
        finally:
            web.stop()
            for work in works[1:]:
                work.cancel()
            await asyncio.gather(*works, return_exceptions=True)


async def _is_led_by_another(store: Store, holder: str) -> bool:
    try:
        leader = (await asyncio.to_thread(store.lease, MASTER)).holder
    except PPaaSError as error:
        logger.debug("the lease of the master cannot be read: %s", error)
        return False
    return leader not in ("", holder)


async def _until(stop: asyncio.Event) -> None:
    await stop.wait()


async def _composed(config: EndpointConfig, stack: contextlib.AsyncExitStack) -> tuple[Web, Endpoint, Store]:
    """Return the web server, the engine's part and the store, which ``stack`` closes."""
    store = open_store(config.store, outbox=_path(config.outbox), reserve=_path(config.reserve))
    stack.callback(store.close)

    async def displace(user: str, robot: str, session: str | None) -> None:
        await web.sessions.displace(user, robot, session)

    def load() -> tuple[int, float]:
        return web.sessions.load()

    run_dir = Path(config.run_dir)
    endpoint = Endpoint(
        config.name, MasterAddress(lambda: UnixAddress(run_dir / SOCKET), config.secret), config.quota, run_dir,
        machine=config.machine, url=config.url, displace=displace, load=load, machines=_machine_access(config),
    )  # fmt: skip
    stack.push_async_callback(endpoint.close)
    await endpoint.start()
    web = Web(
        await _services(config, endpoint, store, stack),
        endpoint.sessions,
        linger=config.linger,
        dead=config.dead,
        log_level=config.log_level,
        connections=connection_table(raise_file_limit(), config.max_connections, config.max_connections_per_address),
        settings=FrontSettings(config.root_path, config.trusted_proxy, config.allow_origin),
        tls=ServerTls(Path(config.tls_cert), Path(config.tls_key)) if config.tls_cert else None,
    )
    stack.push_async_callback(web.close)
    return web, endpoint, store


async def _services(
    config: EndpointConfig, endpoint: Endpoint, store: Store, stack: contextlib.AsyncExitStack
) -> Services:
    """Return the services of the application, connected with those of other processes; ``stack`` closes them."""
    turns, reserve = MasterTurns(endpoint.master), _path(config.reserve)
    accounts = Accounts(store, logins=MasterLogins(endpoint.master), turns=turns)
    stack.callback(accounts.close)
    services = Services(
        store,
        open_map_store(config.map_store, reserve=reserve),
        accounts,
        endpoint.cloud,
        usage=Usage(turns),
        disk=DiskReserve(reserve) if reserve is not None else None,
        recordings=RecordingsFolder(Path(config.recordings)) if config.recordings else None,
        keep_versions=config.keep_versions,
        audit=await stack.enter_async_context(cloud_audit(Path(config.data), is_cloud=False)),
        endpoint=config.name,
    )
    caches = Caches(services)
    endpoint.connect_caches(caches.hear, caches.drop_all)
    endpoint.answer_by(RobotFacts(services).here)
    return services


def _path(text: str | None) -> Path | None:
    return Path(text) if text else None


def _machine_access(config: EndpointConfig) -> MachineAccess | None:
    if config.machines is None or config.listen_machines is None:
        return None
    from engine.remote.authority import Authority  # noqa: PLC0415 - imports cryptography, for other hosts only

    context = Authority(Path(config.machines)).identity.server_context()
    return MachineAccess(parse_host_port(config.listen_machines), context)


async def _listen(config: EndpointConfig, web: Web, stack: contextlib.AsyncExitStack) -> None:
    listeners = listen(config.host, config.port, shared=True)
    rapyuta = [] if config.rapyuta is None else listen(config.host, config.rapyuta, shared=True)
    foxglove = [] if config.foxglove is None else listen(config.host, config.foxglove, shared=True)
    for listener in (*listeners, *rapyuta, *foxglove):
        stack.enter_context(listener)
    if rapyuta:
        web.serve_rapyuta(rapyuta)
    if foxglove:
        web.serve_foxglove(foxglove)
    await web.serve(listeners)
