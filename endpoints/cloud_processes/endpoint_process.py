"""Endpoint process: composes the web server and the engine's part, and runs both until it is stopped."""

import asyncio
import contextlib
import logging
from pathlib import Path
from typing import TYPE_CHECKING

import uvloop

from endpoints.accounts.accounts import Accounts
from endpoints.accounts.shared_logins import SharedLogins
from endpoints.accounts.usage import Usage
from endpoints.accounts.user_turns import MasterTurns
from endpoints.audit.data_folder import DataFolderCalls, FarAuditLog
from endpoints.audit.event import AuditLog
from endpoints.audit.file_log import cloud_audit
from endpoints.cloud_processes.config import Config, EndpointConfig, FrontConfig
from endpoints.cloud_processes.following import FollowedSettings, oidc_logins
from endpoints.http.connection_table import connection_table, raise_file_limit
from endpoints.http.front_settings import FrontSettings
from endpoints.http.tls import ServerTls
from endpoints.listeners import listen
from endpoints.resources.news import Caches, RobotFacts
from endpoints.resources.services import Services
from endpoints.retention.calls import RetentionCalls
from endpoints.robot_checks.clone_checker import CloneChecker
from endpoints.settings.live import LiveCalls
from endpoints.web import Web
from endpoints.webhooks.calls import WebhookCalls
from engine.calls.interface import remote
from engine.cloud_client.endpoint import Endpoint, Here
from engine.cloud_client.link_listener import MachineAccess
from engine.cloud_client.master_link import OwnMaster
from engine.control.journeys.calls import JourneyCalls
from engine.control.master_calls.interface import RequestCounts
from engine.control.master_calls.server import SOCKET
from engine.leadership.leadership import MASTER
from engine.processes.background import Background, cancel_all, run_unless_stopped, stop_on_signals
from engine.processes.imports import without_collection
from engine.processes.run_dir import add_owner
from engine.protocols.address import UnixAddress, parse_host_port
from ppaas.errors import PPaaSError
from ppaas.plugins import permit_only
from storage.disk_space import DiskReserve
from storage.ports import Store
from storage.recordings import RecordingsFolder
from storage.urls.opening import open_map_store, open_store

if TYPE_CHECKING:
    from endpoints.cloud_processes.joined import JoinedEndpoint

logger = logging.getLogger(__name__)


def run(config: Config) -> None:
    """Serve until SIGTERM, or until there was no master for some time.

    Raises
    ------
    Conflict, NotPermitted
        The master refuses this endpoint.
    PPaaSError
        As of ``joined``.
    Unavailable
        The port or a store cannot be used.
    """
    uvloop.run(_run(config))


async def _run(config: Config) -> None:
    stop = stop_on_signals()
    if isinstance(config, EndpointConfig):
        await _serve(config, None, stop)
        return
    from endpoints.cloud_processes.joined import joined  # noqa: PLC0415 - imports cryptography, for other hosts only

    add_owner(Path(config.run_dir))  # kept while this process runs, also if the agent of the machine is killed
    found = await run_unless_stopped(stop, joined(config))
    if found is not None:
        await _serve(found.config, found, stop)


async def _serve(config: EndpointConfig, far: "JoinedEndpoint | None", stop: asyncio.Event) -> None:
    permit_only(config.allowed)
    async with contextlib.AsyncExitStack() as stack:
        linked: list[asyncio.Task[None]] = []  # ends after the services, whose last words are for the master
        with without_collection():
            web, endpoint, followed = await _composed(config, far, stack, linked)
        linked.append(asyncio.create_task(endpoint.run(config.orphaned)))
        following = Background()
        stack.push_async_callback(following.cancel)
        following.run(followed.run(remote(LiveCalls, endpoint.master)))
        serving, stopping = asyncio.create_task(_listen(config.front, web, stack)), asyncio.create_task(_until(stop))
        try:
            done, _ = await asyncio.wait((*linked, serving, stopping), return_when=asyncio.FIRST_COMPLETED)
            for work in done:
                work.result()
        finally:
            web.stop()
            stopping.cancel()
            await asyncio.gather(serving, stopping, return_exceptions=True)


async def _is_led_by_another(store: Store, holder: str) -> bool:
    try:
        leader = (await asyncio.to_thread(store.lease, MASTER)).holder
    except PPaaSError as error:
        logger.debug("the lease of the master cannot be read: %s", error)
        return False
    return leader not in ("", holder)


async def _until(stop: asyncio.Event) -> None:
    await stop.wait()


async def _composed(
    config: EndpointConfig,
    far: "JoinedEndpoint | None",
    stack: contextlib.AsyncExitStack,
    linked: list[asyncio.Task[None]],
) -> tuple[Web, Endpoint, FollowedSettings]:
    """Return the web server, the engine's part and what changes both; ``stack`` closes them, and ends ``linked``."""
    front = config.front
    store = open_store(config.store, outbox=_path(config.outbox), reserve=_path(config.reserve))
    stack.callback(store.close)

    async def displace(user: str, robot: str, session: str | None) -> None:
        await web.sessions.displace(user, robot, session)

    def load() -> tuple[int, float, RequestCounts]:
        return *web.sessions.load(), web.requests.counts()

    endpoint = Endpoint(
        Here(
            config.name, config.machine, Path(config.run_dir), front.url, front.advertised,
            _machine_access(config) if far is None else far.machines,
        ),
        _own_master(config, store) if far is None else far.master,
        config.quota, displace=displace, load=load,
    )  # fmt: skip
    stack.push_async_callback(endpoint.close)
    stack.push_async_callback(cancel_all, linked)
    await endpoint.start()
    web = Web(
        await _services(config, endpoint, store, stack, is_far=far is not None),
        endpoint.sessions,
        linger=config.linger,
        dead=front.dead,
        log_level=front.log_level,
        connections=connection_table(raise_file_limit(), front.max_connections, front.max_connections_per_address),
        settings=_settings(front),
        tls=ServerTls(Path(front.tls_cert), Path(front.tls_key)) if front.tls_cert else None,
    )
    stack.push_async_callback(web.close)
    return web, endpoint, FollowedSettings(config, web, endpoint.cloud.quotas, is_far=far is not None)


def _settings(front: FrontConfig) -> FrontSettings:
    site = Path(front.docs_site) if front.docs_site else None
    return FrontSettings(front.root_path, front.trusted_proxy, front.allow_origin, docs_site=site)


def _own_master(config: EndpointConfig, store: Store) -> OwnMaster:
    return OwnMaster(
        UnixAddress(Path(config.run_dir) / SOCKET), config.secret, lambda: _is_led_by_another(store, config.holder)
    )


async def _services(
    config: EndpointConfig, endpoint: Endpoint, store: Store, stack: contextlib.AsyncExitStack, *, is_far: bool
) -> Services:
    turns, reserve = MasterTurns(endpoint.master), _path(config.reserve)
    accounts = Accounts(store, logins=remote(SharedLogins, endpoint.master), turns=turns)
    stack.callback(accounts.close)
    far_folder = remote(DataFolderCalls, endpoint.master) if is_far else None
    clones = CloneChecker(Path(config.run_dir))
    stack.push_async_callback(clones.close)
    services = Services(
        store,
        open_map_store(config.map_store, reserve=reserve),
        accounts,
        endpoint.cloud,
        usage=Usage(turns),
        clones=clones,
        disk=DiskReserve(reserve) if reserve is not None else None,
        recordings=RecordingsFolder(Path(config.recordings)) if config.recordings else None,
        keep_versions=config.keep_versions,
        far_folder=far_folder,
        audit=await _audit(config, far_folder, stack),
        webhooks=remote(WebhookCalls, endpoint.master),
        retention=remote(RetentionCalls, endpoint.master),
        journeys=remote(JourneyCalls, endpoint.master),
        oidc=oidc_logins(config.front.oidc),
        endpoint=config.name,
    )
    stack.push_async_callback(services.plan_writer.close)
    caches = Caches(services)
    endpoint.connect_caches(caches.hear, caches.drop_all)
    endpoint.answer_by(RobotFacts(services).here)
    return services


async def _audit(
    config: EndpointConfig, far_folder: DataFolderCalls | None, stack: contextlib.AsyncExitStack
) -> AuditLog:
    if far_folder is None:
        return await stack.enter_async_context(cloud_audit(Path(config.data), is_cloud=False))
    log = FarAuditLog(far_folder)
    stack.push_async_callback(log.close)
    return log


def _path(text: str | None) -> Path | None:
    return Path(text) if text else None


def _machine_access(config: EndpointConfig) -> MachineAccess | None:
    if config.machines is None or config.listen_machines is None:
        return None
    from engine.remote.authority import Authority  # noqa: PLC0415 - imports cryptography, for other hosts only

    authority = Authority(Path(config.machines)).identity.authority
    return MachineAccess(parse_host_port(config.listen_machines).host, authority)


async def _listen(front: FrontConfig, web: Web, stack: contextlib.AsyncExitStack) -> None:
    listeners = listen(front.host, front.port, shared=True)
    for listener in listeners:
        stack.enter_context(listener)
    for protocol, port in (("rapyuta", front.rapyuta), ("foxglove", front.foxglove)):
        if port is not None:
            others = listen(front.host, port, shared=True)
            for listener in others:
                stack.enter_context(listener)
            web.serve_protocol(protocol, others)
    await web.serve(listeners)
