"""Process of the master: decides about the cloud, and keeps its endpoints running, from start to clean stop."""

import argparse
import asyncio
import contextlib
import logging
import os
import secrets
from collections.abc import Callable, Coroutine, Iterator, Sequence
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import msgspec
import uvloop

from endpoints.accounts.accounts import Accounts
from endpoints.accounts.shared_logins import LocalLogins, SharedLogins
from endpoints.accounts.usage import Usage
from endpoints.accounts.user_turns import LocalTurns, ServedTurns, TurnCalls, UserTurns
from endpoints.audit.data_folder import DataFolderCalls
from endpoints.audit.event import AuditEvent, AuditLog
from endpoints.audit.file_log import FileAuditLog, cloud_audit
from endpoints.cloud_processes.cloud_jobs import CloudJobs
from endpoints.cloud_processes.config import front_config, with_settings
from endpoints.cloud_processes.keeper import COMMAND, EndpointKeeper, joined_processes
from endpoints.cloud_processes.leading import asked_to_hand_over, hand_over, take_the_lead
from endpoints.cloud_processes.ports import ENDPOINTS_HERE, Ports, endpoint_configs
from endpoints.cloud_processes.reloading import FollowingMaster, SettingsReload, target_rules
from endpoints.http.connection_table import raise_file_limit
from endpoints.http.tls import server_tls, warn_if_open_to_others
from endpoints.listeners import url_of
from endpoints.metrics.snapshot import CloudSnapshots
from endpoints.oidc.settings import provider_settings
from endpoints.resources.news import Caches, RobotFacts
from endpoints.resources.services import Services
from endpoints.retention.calls import RetentionCalls
from endpoints.retention.kinds import Kept
from endpoints.retention.service import Retention
from endpoints.settings.live import LiveCalls
from endpoints.settings.reload import RunningSettings
from endpoints.store_options import settle_stores, store_urls
from endpoints.webhooks.calls import WebhookCalls
from endpoints.webhooks.service import Webhooks
from engine.bootstrap import CloudConfig, Engine
from engine.control.master_calls.server import Extra
from engine.local.kept_process import SpareProcesses
from engine.master.quotas import Quota
from engine.processes.background import Background, first_of, run_unless_stopped, stop_on_signals
from engine.processes.exclusive_owner import LOCK, sole_owner
from engine.processes.private_files import keep_new_files_private, make_private_folder, warn_if_open, write_private
from engine.processes.service_manager import ServiceManager
from engine.remote.endpoint_processes import EndpointProcesses
from engine.remote.replica import MACHINES
from engine.runtimes.compilation.cache_folder import ensure_cache
from engine.tracing.recording import begin_traces, end_traces
from ppaas.distribution import check_versions, install_hint
from ppaas.errors import InvalidInput
from ppaas.log_lines import log_lines
from ppaas.messages.health.stops import RobotStop
from ppaas.plugins import permit_only
from ppaas.wire.foxglove.installed import check_installed
from storage.disk_space import RefusedTokenFile
from storage.recordings import RECORDINGS
from storage.urls.opening import local_path

if TYPE_CHECKING:
    from endpoints.metrics.collector import CloudCollector

logger = logging.getLogger(__name__)

T = TypeVar("T")

ADMIN = "admin"
"""Id of the first administrator."""

RAY = "ray"
"""Runtime that starts processes on the nodes of a Ray cluster."""

RAY_LISTENS = "0.0.0.0:8501"
"""Default address for machines on a Ray cluster; their routers connect to the next port."""

SETTLED = 10.0
"""Delay of background work after the start [s]: a restarted cloud serves its robots first."""

MACHINE_SETTINGS = "machine-settings.json"
"""File in the data folder with the settings of machines."""

READY_MODE = 0o644
"""Mode of the ready file: a supervisor that runs as another user may read it, and it contains no secret."""


class ReadyFile(msgspec.Struct):
    """Contents of the ready file."""

    url: str
    pid: int
    admin_user: str


def run_server(running: RunningSettings) -> int:
    """Serve until SIGINT or SIGTERM; return the exit status.

    Raises
    ------
    InvalidInput
        The data folder or the password file is unusable, or a plug-in given with ``--allow`` has no such name.
    Unavailable
        Listening on the address failed, or another cloud uses the data folder or the store.
    """
    keep_new_files_private()
    arguments = running.arguments
    level = arguments.log_level.upper()
    form = "%(asctime)s %(levelname)s %(name)s: %(message)s"
    log_lines(form, process="master", level=level, dates="%H:%M:%S")
    if arguments.config is not None:
        logger.info("settings of %s", arguments.config)
    ensure_cache()
    permit_only(arguments.allow)
    if arguments.foxglove is not None:
        check_installed()
    if arguments.metrics is not None:
        _check_metrics_installed()
    _check_listens(arguments)
    provider_settings(arguments)  # reports what is missing before anything starts
    settle_stores(arguments)
    try:
        make_private_folder(arguments.data)
    except OSError as error:
        raise InvalidInput(f"cannot create the data folder: {error}; choose another with --data") from error
    with contextlib.ExitStack() as stack:
        for lock, what, advice in _owned(arguments):
            stack.enter_context(sole_owner(lock, what, advice))
        begin_traces("ppaas-master", "master")
        stack.callback(end_traces)
        uvloop.run(_serve(running))
    return 0


def _owned(arguments: argparse.Namespace) -> Iterator[tuple[Path, str, str]]:
    """Yield the lock of each thing that only one cloud may use, its description, and the advice for another cloud.

    A standby uses the store of another cloud; it is the lease in the store that says who leads.
    """
    yield arguments.data / LOCK, f"the data folder {arguments.data}", "choose another folder with --data"
    if arguments.standby is not None:
        return
    store = local_path(cloud_config(arguments).store)
    if store is not None:
        with contextlib.suppress(OSError):  # the store itself reports what is wrong with its folder
            store.parent.mkdir(parents=True, exist_ok=True)
    if store is not None and store.parent.is_dir():
        advice = "choose another store with --store, or start this one with --standby"
        yield store.with_name(f"{store.name}.{LOCK}"), f"the store {store}", advice


def cloud_config(arguments: argparse.Namespace) -> CloudConfig:
    """Return the configuration of the cloud from the command line."""
    data, (store, map_store) = arguments.data.resolve(), store_urls(arguments)
    on_ray = arguments.runtime == RAY
    for option in ("ray_address", "ray_endpoints"):
        if getattr(arguments, option) and not on_ray:
            raise InvalidInput(f"--{option.replace('_', '-')} needs --runtime ray")
    return CloudConfig(
        store=store,
        map_store=map_store,
        outbox=str(data / "outbox.sqlite"),
        reserve=str(data),
        recordings=str(data / RECORDINGS),
        keep_versions=arguments.keep_versions,
        listen_machines=arguments.listen_machines or (RAY_LISTENS if on_ray else None),
        machines=str(data / MACHINES),
        join_secrets=_path_or_none(arguments.join_secret_file),
        standby_secrets=_path_or_none(arguments.standby_secret_file),
        masters=tuple(arguments.master),
        machine_settings=str(data / MACHINE_SETTINGS),
        left=str(data),
        adopt_within=arguments.adopt_within,
        cores=arguments.cores,
        balancer=arguments.balancer,
        runtime="process" if on_ray else arguments.runtime,
        ray_address=arguments.ray_address or ("auto" if on_ray else None),
        ray_endpoints=_ray_endpoints(arguments),
        image=arguments.image,
        allowed=tuple(arguments.allow),
        device_hosts=tuple(arguments.device_host),
        node_priorities=tuple(filter(None, arguments.node_priorities.split(","))),
        linger=arguments.linger,
        quota=Quota(**dict(arguments.quota)),
    )


def _check_listens(arguments: argparse.Namespace) -> None:
    """Check that machines can come to show a secret; raises ``InvalidInput`` otherwise."""
    for option in ("join_secret_file", "standby_secret_file"):
        if getattr(arguments, option) is not None and arguments.listen_machines is None:
            raise InvalidInput(f"--{option.replace('_', '-')} needs --listen-machines HOST:PORT")


def _path_or_none(path: Path | None) -> str | None:
    return None if path is None else str(path.resolve())


def _ray_endpoints(arguments: argparse.Namespace) -> EndpointProcesses | None:
    """Return the endpoints of the nodes of a Ray cluster from the command line; None for none."""
    if not arguments.ray_endpoints:
        return None
    return joined_processes(arguments.ray_endpoints, front_config(arguments, port=arguments.port))


def admin_password(path: Path) -> str:
    """Return the password in a file; a missing file is created with a new password, readable by this user only.

    An empty file counts as missing: releases before 0.2 left one if they were killed while they created it.
    """
    try:
        if path.exists() and (password := path.read_text().strip()):
            warn_if_open(path)
            return password
        password = secrets.token_urlsafe(12)
        write_private(path, f"{password}\n".encode())
    except OSError as error:
        raise InvalidInput(f"cannot read or create the password file: {error}") from error
    return password


async def _serve(running: RunningSettings) -> None:
    stop, asked, manager = stop_on_signals(), asked_to_hand_over(), ServiceManager()
    arguments, reload = running.arguments, SettingsReload(running)
    async with contextlib.AsyncExitStack() as stack:
        stack.push_async_callback(manager.stop)
        manager.start()
        stack.push_async_callback(reload.close)
        reload.on_hangup(stop)
        if arguments.standby is not None:  # it may wait for as long as another process leads
            manager.notify(READY="1", STATUS="standing by, or taking over")
        metrics = await _metrics(reload, stack)
        config = cloud_config(arguments)
        spares = SpareProcesses(COMMAND)
        stack.push_async_callback(spares.close)
        leadership = await run_unless_stopped(stop, take_the_lead(arguments, config, spares, stack))
        if leadership is None:
            return
        if metrics is not None:
            metrics.leadership = leadership
        ports = Ports.reserve(arguments, stack)
        tls = server_tls(arguments.tls_cert, arguments.tls_key)
        if tls is None:
            warn_if_open_to_others(ports.web)
        raise_file_limit()  # before processes are started, which inherit it
        engine = Engine(cloud_config(arguments), leadership)  # of now: a standby may have waited for days
        stack.push_async_callback(engine.close)
        started = await run_unless_stopped(stop, _start(engine, reload, stack, ports, spares))
        if started is not None:
            keeper, snapshots = started
            if metrics is not None:
                metrics.source = snapshots
            ports.log(tls=tls is not None)
            url = url_of(ports.web[0], "http" if tls is None else "https")
            manager.notify(READY="1", STATUS=f"serving at {url}")
            await _run((stop, asked), url, arguments.ready_file)
            if asked.is_set() and not stop.is_set():
                await hand_over(leadership, engine.store, engine.end_own_machine, keeper.stop)
            await keeper.stop()


async def _start(
    engine: Engine,
    reload: SettingsReload,
    stack: contextlib.AsyncExitStack,
    ports: Ports,
    spares: SpareProcesses,
) -> tuple[EndpointKeeper, CloudSnapshots]:
    arguments = reload.arguments
    audit = await stack.enter_async_context(cloud_audit(arguments.data))
    services = await _services(engine, arguments, stack, audit)
    webhooks, retention = _called_jobs(engine, arguments, audit)
    engine.endpoints.serve_also(lambda: Extra(LiveCalls, reload))
    machine = asyncio.create_task(engine.start())
    kept = retention.seconds("tasks")
    tasks = engine.cloud.task_runner(engine.store, engine.map_store, kept, engine.journeys)
    try:
        await _ensure_admin(services.accounts, arguments, stack)
        await engine.listening()
        configs = endpoint_configs(arguments, engine, ports)
        keeper = EndpointKeeper(configs, engine.endpoints, engine.run_dir, arguments.data / ENDPOINTS_HERE, spares)
        stack.push_async_callback(keeper.stop)
        reload.follow(lambda _: keeper.change([with_settings(each, reload.live) for each in configs]))
        await keeper.start()
        await machine
        jobs = CloudJobs(
            services, engine.sessions, arguments.idle, tasks, events=engine.cloud.events,
            others=(webhooks, retention, engine.journeys),
        )  # fmt: skip
        stack.push_async_callback(jobs.close)
        jobs.start()
        reload.follow(FollowingMaster(engine.cloud, services, jobs, webhooks, retention, tasks).apply)
    finally:
        machine.cancel()
        await asyncio.gather(machine, return_exceptions=True)
    return keeper, CloudSnapshots(services, engine.cloud, tasks, webhooks, arguments.tls_cert)


async def _services(
    engine: Engine, arguments: argparse.Namespace, stack: contextlib.AsyncExitStack, audit: FileAuditLog
) -> Services:
    """Return the services. Endpoints are served too: on joined machines they call as soon as the engine starts."""
    refused = RefusedTokenFile(arguments.data)
    revoked = await asyncio.to_thread(refused.open)
    logins, turns = LocalLogins(file=refused), LocalTurns()
    logins.on_forget(partial(engine.cloud.announce, "user"))
    engine.endpoints.serve_also(lambda: Extra(SharedLogins, logins))
    engine.endpoints.serve_also(partial(_served_turns, turns))
    services = Services(
        engine.store, engine.map_store, Accounts(engine.store, logins=logins, turns=turns), engine.cloud,
        usage=Usage(turns), disk=engine.reserve,
        recordings=engine.recordings, keep_versions=engine.keep_versions,
        audit=audit,
    )  # fmt: skip
    engine.endpoints.serve_also(lambda: Extra(DataFolderCalls, services.data_folder))
    stack.callback(services.accounts.close)
    await services.accounts.refuse(revoked)
    engine.cloud.news.listen(Caches(services).hear)
    engine.cloud.fact_sources.add(RobotFacts(services).here)
    engine.cloud.robot_stops.requested = partial(_record_request, services.audit)
    return services


def _called_jobs(engine: Engine, arguments: argparse.Namespace, audit: FileAuditLog) -> tuple[Webhooks, Retention]:
    """Return the jobs that endpoints call."""
    rules = target_rules(arguments)
    webhooks = Webhooks(engine.store, engine.cloud.events, rules, audit, hear_goals=engine.cloud.hear_goals)
    kept, sizes = Kept(engine.store, audit, engine.recordings), dict(arguments.retention_size)
    retention = Retention(kept, audit, dict(arguments.retention), gigabytes=sizes)
    engine.endpoints.serve_also(lambda: Extra(WebhookCalls, webhooks))
    engine.endpoints.serve_also(lambda: Extra(RetentionCalls, retention))
    return webhooks, retention


def _record_request(audit: AuditLog, user: str, stop: RobotStop) -> None:
    """Record that a client has stopped a robot by its socket, as which it is not known who it is."""
    audit.record(AuditEvent(action="stop_robot", object=f"robots/{user}:{stop.name}", details={"reason": stop.reason}))


def _check_metrics_installed() -> None:
    if find_spec("prometheus_client") is None:
        raise InvalidInput(f"--metrics needs the extra metrics: {install_hint('cloud', 'metrics')}")
    check_versions("metrics")


async def _metrics(reload: SettingsReload, stack: contextlib.AsyncExitStack) -> "CloudCollector | None":
    """Serve metrics until ``stack`` is closed, if the command line wants them; return what collects them."""
    arguments = reload.arguments
    if arguments.metrics is None:
        return None
    from endpoints.metrics.server import serve_metrics  # noqa: PLC0415 - imports prometheus_client, of an extra

    collector, end = await serve_metrics(arguments.metrics, robots=arguments.metrics_robots)
    stack.push_async_callback(asyncio.to_thread, end)
    reload.follow(lambda now: setattr(collector, "robots", now.metrics_robots))
    return collector


def _served_turns(turns: UserTurns) -> Extra:
    served = ServedTurns(turns)
    return Extra(TurnCalls, served, served.close)


async def _ensure_admin(accounts: Accounts, arguments: argparse.Namespace, stack: contextlib.AsyncExitStack) -> None:
    password_file = arguments.admin_password_file or arguments.data / "admin-password"
    password = await asyncio.to_thread(admin_password, password_file)
    admin = await accounts.ensure_admin(password)
    logger.info("the password of user %r is in %s", ADMIN, password_file)
    background = Background()
    stack.push_async_callback(background.cancel)
    background.run(_later(partial(accounts.warn_if_different, admin, password)))


async def _later(work: Callable[[], Coroutine[Any, Any, None]]) -> None:
    """Run background work once the clients that waited for the cloud have been served."""
    await asyncio.sleep(SETTLED)
    await work()


async def _run(ends: Sequence[asyncio.Event], url: str, ready_file: Path | None) -> None:
    """Serve until one of the events is set."""
    logger.info("serving at %s", url)
    if ready_file is not None:
        await asyncio.to_thread(_write_ready, ready_file, ReadyFile(url, os.getpid(), ADMIN))
    await first_of(ends)


def _write_ready(path: Path, ready: ReadyFile) -> None:
    partial = path.with_suffix(".partial")
    try:
        partial.write_bytes(msgspec.json.encode(ready))
        partial.chmod(READY_MODE)
        partial.rename(path)
    except OSError as error:
        raise InvalidInput(f"cannot write the ready file: {error}") from error
