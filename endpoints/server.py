"""The server process: the cloud and its web application on one event loop, from start to clean stop."""

import argparse
import asyncio
import contextlib
import logging
import os
import secrets
import signal
import socket
from collections.abc import Coroutine, Iterator
from pathlib import Path
from typing import Any, TypeVar

import msgspec
import uvicorn
import uvloop
from fastapi import FastAPI
from starlette.routing import WebSocketRoute
from starlette.websockets import WebSocket

from endpoints.accounts import Accounts
from endpoints.app import create_app
from endpoints.client_sessions import ClientSessions
from endpoints.idle import IdleWatch
from endpoints.robot_socket import serve_robot_socket
from endpoints.services import Services
from endpoints.websocket_protocol import ProbedWebSocket
from engine.background import Background
from engine.bootstrap import Cloud, CloudConfig
from ppaas.errors import InvalidInput, Unavailable

logger = logging.getLogger(__name__)

T = TypeVar("T")

ADMIN = "admin"
MAX_FRAME = 16 * 1024 * 1024
"""Bytes of one frame of a robot: ten times a raw 640×480 depth image."""


class Server(uvicorn.Server):
    """Leaves signals to us, so that the cloud ends before the process does."""

    @contextlib.contextmanager
    def capture_signals(self) -> Iterator[None]:
        """Capture none."""
        yield


class Ready(msgspec.Struct):
    """What the ready file says."""

    url: str
    pid: int
    admin_user: str


def run_server(arguments: argparse.Namespace) -> int:
    """Serve until SIGINT or SIGTERM; return the exit status.

    Raises
    ------
    InvalidInput
        The data folder or the password file cannot be used.
    Unavailable
        The address cannot be listened at.
    """
    logging.basicConfig(
        level=arguments.log_level.upper(), format="%(asctime)s %(levelname)s %(name)s: %(message)s", datefmt="%H:%M:%S"
    )
    try:
        arguments.data.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InvalidInput(f"no data folder can be made: {error}; give another with --data") from error
    uvloop.run(_serve(arguments))
    return 0


def cloud_config(arguments: argparse.Namespace) -> CloudConfig:
    """Return what the arguments say the cloud is made of."""
    data = arguments.data.resolve()
    return CloudConfig(
        store=arguments.store or f"sqlite:///{data / 'ppaas.sqlite'}",
        map_store=arguments.map_store or f"file:///{data / 'maps'}",
        cores=arguments.cores,
        linger=arguments.linger,
    )


def admin_password(path: Path) -> str:
    """Return the password in a file; make the file, readable by this user alone, if it is not there."""
    try:
        if path.exists():
            return path.read_text().strip()
        password = secrets.token_urlsafe(12)
        path.touch(mode=0o600)
        path.write_text(password + "\n")
    except OSError as error:
        raise InvalidInput(f"the password file cannot be read or made: {error}") from error
    return password


def listen(host: str, port: int) -> socket.socket:
    """Return a socket that listens.

    Raises
    ------
    Unavailable
        The address is not ours, or taken.
    """
    try:
        return socket.create_server((host, port), backlog=1024)
    except OSError as error:
        raise Unavailable(f"cannot listen: {error.strerror}; take another --host or --port (0: a free one)") from error


def build_app(cloud: Cloud, accounts: Accounts, sessions: ClientSessions) -> FastAPI:
    """Return the web application of a cloud."""
    services = Services(cloud.store, cloud.map_store, accounts, cloud)
    app = create_app(services)

    async def robot_socket(websocket: WebSocket) -> None:
        await serve_robot_socket(websocket, services, sessions)

    app.router.routes.append(WebSocketRoute("/", robot_socket))
    return app


async def _serve(arguments: argparse.Namespace) -> None:
    stop = _stop_on_signals()
    with listen(arguments.host, arguments.port) as listener:
        cloud = Cloud(cloud_config(arguments))
        sessions = ClientSessions(cloud.sessions, arguments.linger)
        watching = Background()
        try:
            server = await _unless(stop, _start(cloud, sessions, arguments))
            if server is not None:
                watching.run(IdleWatch(sessions, cloud.sessions, arguments.idle).run())
                await _run(server, listener, stop, arguments.ready_file)
        finally:
            await watching.cancel()
            await sessions.close()
            await cloud.close()


def _stop_on_signals() -> asyncio.Event:
    stop = asyncio.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        asyncio.get_running_loop().add_signal_handler(number, stop.set)
    return stop


async def _unless(stop: asyncio.Event, work: Coroutine[Any, Any, T]) -> T | None:
    """Return the result of work; give it up, and return None, if told to stop before it is done."""
    tasks = working, stopping = asyncio.create_task(work), asyncio.create_task(stop.wait())
    try:
        await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
        return working.result() if working.done() else None
    finally:
        working.cancel()
        stopping.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)


async def _start(cloud: Cloud, sessions: ClientSessions, arguments: argparse.Namespace) -> Server:
    await cloud.start()
    accounts = Accounts(cloud.store)
    password_file = arguments.admin_password_file or arguments.data / "admin-password"
    await accounts.ensure_admin(await asyncio.to_thread(admin_password, password_file))
    logger.info("user %r has the password in %s", ADMIN, password_file)
    app = build_app(cloud, accounts, sessions)
    return Server(_uvicorn_config(app, arguments.log_level, arguments.dead))


async def _run(server: Server, listener: socket.socket, stop: asyncio.Event, ready_file: Path | None) -> None:
    url = "http://{}:{}".format(*listener.getsockname()[:2])
    serving, stopping = asyncio.create_task(server.serve([listener])), asyncio.create_task(stop.wait())
    try:
        logger.info("serving at %s", url)
        if ready_file is not None:
            await asyncio.to_thread(_write_ready, ready_file, Ready(url, os.getpid(), ADMIN))
        await asyncio.wait((serving, stopping), return_when=asyncio.FIRST_COMPLETED)
    finally:
        stopping.cancel()
        server.should_exit = True
        await serving


def _uvicorn_config(app: FastAPI, log_level: str, dead: float) -> uvicorn.Config:
    return uvicorn.Config(
        app,
        log_level="error" if log_level == "error" else "warning",  # at "info" it tells of each query
        log_config=None,
        access_log=False,  # a token may stand in the query
        ws_max_size=MAX_FRAME,
        ws=ProbedWebSocket,
        ws_per_message_deflate=False,
        ws_ping_interval=dead / 3.0,  # a socket that dies right after a pong is noticed after both together
        ws_ping_timeout=dead * 2.0 / 3.0,
        timeout_graceful_shutdown=2,
    )


def _write_ready(path: Path, ready: Ready) -> None:
    partial = path.with_suffix(".partial")
    try:
        partial.write_bytes(msgspec.json.encode(ready))
        partial.rename(path)
    except OSError as error:
        raise InvalidInput(f"the ready file cannot be written: {error}") from error
