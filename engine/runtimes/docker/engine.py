"""What is asked of the Docker engine, by its SDK, in threads: the SDK waits for every answer."""

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
from ppaas.errors import Unavailable

try:
    from docker.client import DockerClient
    from docker.errors import DockerException, ImageNotFound, NotFound
    from docker.types import LogConfig, Mount
    from requests import RequestException
except ImportError as error:
    raise Unavailable("the runtime docker needs its extra: pip install 'ppaas[docker]'") from error

logger = logging.getLogger(__name__)

T = TypeVar("T")

INSTANCE = "ppaas.instance"
"""Label that tells to which running cloud a container belongs."""

THREADS = 4
TIMEOUT = 30.0
"""Seconds in which the engine answers."""

LOG_LINES = 20
"""That are told of a container which ended badly."""

UNPRIVILEGED = 10001
"""User id in a container where that of the agent is root's."""

KILLED = 128
"""A container that was ended by signal n has this and n as its exit status."""

Died = Callable[[str, int], None]


class DockerEngine:
    """The engine of this computer, as far as it concerns the containers of one cloud.

    Parameters
    ----------
    instance : str
        Name of that cloud.
    image : str
        Image of its containers.
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
        """Find the engine and the image, remove what dead clouds have left, and watch.

        Parameters
        ----------
        died : callable
            Told on the loop of each container that ended: its id, and its exit status, negative for a signal.
        lost : callable
            Told on the loop when the engine tells nothing any more: it has ended. To go on, connect again.

        Raises
        ------
        Unavailable
            There is no engine, or no such image.
        """
        await self._call(self._find)
        await self._call(self._sweep)
        self._events = await self._call(self._listen)
        loop = asyncio.get_running_loop()
        watch = (self._events, partial(_tell, loop, died), partial(_tell, loop, lost))
        threading.Thread(target=self._watch, args=watch, name="docker-events", daemon=True).start()

    async def run(self, command: Sequence[str], places: Mapping[str, Path], limits: Mapping[str, Any]) -> str:
        """Start a container that may do nothing but compute, and return its id.

        Parameters
        ----------
        command : sequence of str
            What runs in it.
        places : mapping of str to Path
            Folders of this computer that it sees, by where it sees them; it may not write to them.
        limits : mapping
            As ``docker.models.containers.Container.update`` takes them.

        Raises
        ------
        Unavailable
            The engine refuses, or does not answer.
        """
        mounts = [Mount(seen, str(folder), type="bind", read_only=True) for seen, folder in places.items()]
        return await self._call(lambda: self._run(command, mounts, limits))

    async def limit(self, container: str, limits: Mapping[str, Any]) -> None:
        """Limit what a container may use from now on.

        Raises
        ------
        Unavailable
            The engine refuses, or does not answer; or the container is gone.
        """
        await self._call(lambda: self._containers.get(container).update(**limits))

    async def kill(self, container: str) -> None:
        """End a container by force; nothing happens where it has ended."""
        with contextlib.suppress(Unavailable):
            await self._call(lambda: self._containers.get(container).kill())

    async def bury(self, container: str) -> str:
        """Remove a container that has ended, or is to; return the last that it said."""
        with contextlib.suppress(Unavailable):
            return await self._call(lambda: self._bury(container))
        return ""

    async def close(self) -> None:
        """Remove all containers of this cloud, running or not, and let go of the engine."""
        if self._under_way:
            await asyncio.wait(self._under_way)  # else one that is just being started would be left
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
        asked = asyncio.get_running_loop().run_in_executor(self._threads, blocking)
        self._under_way.add(asked)
        asked.add_done_callback(self._answered)
        try:
            return await asyncio.shield(asked)
        except (DockerException, RequestException) as error:
            raise Unavailable(f"the Docker engine: {error}") from error

    def _answered(self, asked: asyncio.Future[Any]) -> None:
        self._under_way.discard(asked)
        if not asked.cancelled():
            asked.exception()  # whoever asked may have given up, and then nobody takes it

    @property
    def _containers(self) -> Any:
        if self._client is None:
            raise Unavailable("the Docker engine was not asked yet whether it is there")
        return self._client.containers

    def _find(self) -> None:
        try:
            self._client = DockerClient.from_env(timeout=TIMEOUT)
            self._client.images.get(self._image)
        except ImageNotFound as error:
            build = f"docker build -f docker/engine.Dockerfile -t {self._image} ."
            raise Unavailable(f"there is no image {self._image!r}; make it in a checkout by: {build}") from error
        except (DockerException, RequestException) as error:
            advice = "start it, let this user reach its socket, or take --runtime process"
            raise Unavailable(f"no Docker engine answers: {error}; {advice}") from error

    def _sweep(self) -> None:
        for container in self._containers.list(all=True, filters={"label": INSTANCE}, ignore_removed=True):
            if is_dead(container.labels[INSTANCE]):
                _remove(container)

    def _listen(self) -> Any:
        if self._client is None:
            raise Unavailable("the Docker engine was not asked yet whether it is there")
        filters = {"type": "container", "event": "die", "label": f"{INSTANCE}={self._instance}"}
        return self._client.events(decode=True, filters=filters)

    def _watch(self, events: Any, died: Died, lost: Callable[[], None]) -> None:
        try:
            for event in events:
                actor = event["Actor"]
                status = int(actor["Attributes"]["exitCode"])
                died(actor["ID"], KILLED - status if status > KILLED else status)
        except (DockerException, RequestException, OSError, ValueError) as error:
            logger.warning("the Docker engine broke off: %s", error)
        finally:
            if not self._closed:
                lost()

    def _run(self, command: Sequence[str], mounts: list[Mount], limits: Mapping[str, Any]) -> str:
        container = self._containers.run(
            self._image,
            entrypoint=command[:1],
            command=command[1:],
            detach=True,
            init=True,  # else nobody in it could be killed from inside, as whoever loses its machine is
            network_mode="none",
            read_only=True,
            tmpfs={"/tmp": "size=64m,mode=1777"},
            mounts=mounts,
            user=f"{os.getuid() or UNPRIVILEGED}:{os.getgid() or UNPRIVILEGED}",
            cap_drop=["ALL"],
            security_opt=["no-new-privileges"],
            labels={INSTANCE: self._instance},
            log_config=LogConfig(type="json-file", config={"max-size": "1m"}),
            **limits,
        )
        return str(container.id)

    def _bury(self, container: str) -> str:
        found = self._containers.get(container)
        said: bytes = found.logs(tail=LOG_LINES)
        _remove(found)
        return said.decode(errors="replace").strip()

    def _remove_all(self) -> None:
        ours = {"label": f"{INSTANCE}={self._instance}"}
        for container in self._containers.list(all=True, filters=ours, ignore_removed=True):
            _remove(container)


def _tell(loop: asyncio.AbstractEventLoop, told: Callable[..., None], *arguments: object) -> None:
    with contextlib.suppress(RuntimeError):  # the loop has ended, and nobody waits any longer
        loop.call_soon_threadsafe(told, *arguments)


def _remove(container: Any) -> None:
    with contextlib.suppress(NotFound):  # another may sweep at the same time
        container.remove(force=True, v=True)
