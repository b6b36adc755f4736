"""Client of the Docker Engine: calls its SDK, which blocks, in threads."""

import asyncio
import contextlib
import logging
import os
import threading
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

from engine.processes.instances import is_dead
from ppaas.distribution import check_versions, install_hint
from ppaas.errors import Unavailable
from ppaas.log_lines import AS_JSON, VARIABLE, is_json

check_versions("docker")
try:
    from docker.client import DockerClient
    from docker.errors import DockerException, ImageNotFound, NotFound
    from docker.types import LogConfig, Mount
    from requests import RequestException
except ImportError as error:
    raise Unavailable(f"the docker runtime needs the extra docker: {install_hint('docker')}") from error

logger = logging.getLogger(__name__)

T = TypeVar("T")

INSTANCE = "ppaas.instance"
"""Label with the name of the cloud process that a container belongs to."""

THREADS = 4
TIMEOUT = 30.0
"""Time limit of a call to the engine [s]."""

LOG_LINES = 20
"""Number of log lines that are reported of a container that failed."""

UNPRIVILEGED = 10001
"""User and group id in a container when the agent runs as root."""

KILLED = 128
"""Offset of signals in exit statuses: a container killed by signal n has the status 128 + n."""

Died = Callable[[str, int], None]


class DockerEngine:
    """The Docker Engine of this computer, restricted to the containers of one cloud process.

    Parameters
    ----------
    instance : str
        Name of the cloud process.
    image : str
        Image of the containers.
    """

    def __init__(self, instance: str, image: str) -> None:
        self._instance = instance
        self._image = image
        self._threads = ThreadPoolExecutor(THREADS, "docker")
        self._client: DockerClient | None = None
        self._events: Any = None
        self._closed = False
        self._under_way: set[asyncio.Future[Any]] = set()

    async def connect(self, died: Died, lost: Callable[[], None]) -> None:
        """Find the engine and the image, remove containers of dead cloud processes, and watch for ends of containers.

        Parameters
        ----------
        died : callable
            Called on the loop for each container that exited, with its id and its exit status, negative for a signal.
        lost : callable
            Called on the loop when the connection to the engine has ended. Call ``connect`` again to go on.

        Raises
        ------
        Unavailable
            The engine does not answer, or has no such image.
        """
        await self._call(self._find)
        await self._call(self._sweep)
        self._events = await self._call(self._listen)
        loop = asyncio.get_running_loop()
        watch = (self._events, partial(_call_on, loop, died), partial(_call_on, loop, lost))
        threading.Thread(target=self._watch, args=watch, name="docker-events", daemon=True).start()

    async def run(self, command: Sequence[str], places: Mapping[str, Path], limits: Mapping[str, Any]) -> str:
        """Start a container without network and privileges, and return its id.

        Parameters
        ----------
        command : sequence of str
            Command that runs in it.
        places : mapping of str to Path
            Folders of this computer to mount read-only, by their paths in the container.
        limits : mapping
            Options of ``docker.models.containers.Container.update``.

        Raises
        ------
        Unavailable
            The engine refuses, or does not answer.
        """
        mounts = [Mount(seen, str(folder), type="bind", read_only=True) for seen, folder in places.items()]
        return await self._call(lambda: self._run(command, mounts, limits))

    async def limit(self, container: str, limits: Mapping[str, Any]) -> None:
        """Change the resource limits of a container.

        Raises
        ------
        Unavailable
            The engine refuses, or does not answer; or the container does not exist.
        """
        await self._call(lambda: self._containers.get(container).update(**limits))

    async def kill(self, container: str) -> None:
        """Kill a container. Does nothing if it has exited."""
        with contextlib.suppress(Unavailable):
            await self._call(lambda: self._containers.get(container).kill())

    async def remove(self, container: str) -> str:
        """Kill and remove a container; return its last log lines."""
        with contextlib.suppress(Unavailable):
            return await self._call(lambda: self._remove(container))
        return ""

    async def close(self) -> None:
        """Remove all containers of this cloud process, running or not, and close the connection."""
        if self._under_way:
            await asyncio.wait(self._under_way)  # otherwise a container that is just being started would be left behind
        with contextlib.suppress(Unavailable):
            await self._call(self._remove_all)
        self._closed = True
        if self._events is not None:
            self._events.close()
        if self._client is not None:
            self._client.close()
        self._threads.shutdown(wait=False)

    # -- in threads ----------------------------------------------------------------------------------------------------

    async def _call(self, blocking: Callable[[], T]) -> T:
        call = asyncio.get_running_loop().run_in_executor(self._threads, blocking)
        self._under_way.add(call)
        call.add_done_callback(self._finished)
        try:
            return await asyncio.shield(call)
        except (DockerException, RequestException) as error:
            raise Unavailable(f"the Docker Engine refuses: {error}") from error

    def _finished(self, call: asyncio.Future[Any]) -> None:
        self._under_way.discard(call)
        if not call.cancelled():
            call.exception()  # retrieve it: the caller may have been cancelled

    @property
    def _containers(self) -> Any:
        if self._client is None:
            raise Unavailable("there is no connection to the Docker Engine yet")
        return self._client.containers

    def _find(self) -> None:
        try:
            self._client = DockerClient.from_env(timeout=TIMEOUT)
            self._client.images.get(self._image)
        except ImageNotFound as error:
            build = f"docker build -f docker/engine.Dockerfile -t {self._image} ."
            raise Unavailable(f"there is no image {self._image!r}; build it in a checkout with: {build}") from error
        except (DockerException, RequestException) as error:
            advice = "start it, give this user access to its socket, or use --runtime process"
            raise Unavailable(f"no Docker Engine answers: {error}; {advice}") from error

    def _sweep(self) -> None:
        for container in self._containers.list(all=True, filters={"label": INSTANCE}, ignore_removed=True):
            if is_dead(container.labels[INSTANCE]):
                _remove(container)

    def _listen(self) -> Any:
        if self._client is None:
            raise Unavailable("there is no connection to the Docker Engine yet")
        filters = {"type": "container", "event": "die", "label": f"{INSTANCE}={self._instance}"}
        return self._client.events(decode=True, filters=filters)

    def _watch(self, events: Any, died: Died, lost: Callable[[], None]) -> None:
        try:
            for event in events:
                actor = event["Actor"]
                status = int(actor["Attributes"]["exitCode"])
                died(actor["ID"], KILLED - status if status > KILLED else status)
        except (DockerException, RequestException, OSError, ValueError) as error:
            logger.warning("the connection to the Docker Engine broke off: %s", error)
        finally:
            if not self._closed:
                lost()

    def _run(self, command: Sequence[str], mounts: list[Mount], limits: Mapping[str, Any]) -> str:
        container = self._containers.run(
            self._image,
            entrypoint=command[:1],
            command=command[1:],
            detach=True,
            init=True,  # otherwise our process would be PID 1, which signals from inside the container cannot kill
            network_mode="none",
            read_only=True,
            tmpfs={"/tmp": "size=64m,mode=1777"},
            mounts=mounts,
            user=f"{os.getuid() or UNPRIVILEGED}:{os.getgid() or UNPRIVILEGED}",
            cap_drop=["ALL"],
            security_opt=["no-new-privileges"],
            labels={INSTANCE: self._instance},
            environment={VARIABLE: AS_JSON} if is_json() else {},
            log_config=LogConfig(type="json-file", config={"max-size": "1m"}),
            **limits,
        )
        return str(container.id)

    def _remove(self, container: str) -> str:
        found = self._containers.get(container)
        log: bytes = found.logs(tail=LOG_LINES)
        _remove(found)
        return log.decode(errors="replace").strip()

    def _remove_all(self) -> None:
        ours = {"label": f"{INSTANCE}={self._instance}"}
        for container in self._containers.list(all=True, filters=ours, ignore_removed=True):
            _remove(container)


def _call_on(loop: asyncio.AbstractEventLoop, callback: Callable[..., None], *arguments: object) -> None:
    with contextlib.suppress(RuntimeError):  # the loop is closed
        loop.call_soon_threadsafe(callback, *arguments)


def _remove(container: Any) -> None:
    with contextlib.suppress(NotFound):  # another process may remove it at the same time
        container.remove(force=True, v=True)
