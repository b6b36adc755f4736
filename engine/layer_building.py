"""Makes the layers of a map in a process of its own: warm from the first call, and alone if it runs out of memory."""

import asyncio
import multiprocessing
import os
from contextlib import suppress
from multiprocessing.connection import Connection
from pathlib import Path

from engine.layer_files import write_layers
from engine.link import Refusal
from engine.runtimes.child import die_with_parent
from engine.runtimes.fork_server import UNHEARD, start_process
from ppaas.errors import PPaaSError, Unavailable, rebuild
from storage.records import MapRecord


def build_here(record: MapRecord, robot_radius: float, folder: Path) -> None:
    """Make the layers of a map and write them into a folder.

    Raises
    ------
    InvalidMap
        The files are no map.
    Unavailable
        There is no room.
    """
    # Loaded in the process that builds: numba is not for the agent.
    from ppaas.costmap.build import build_layers  # noqa: PLC0415
    from ppaas.maps.files import load_map  # noqa: PLC0415

    grid = load_map(record.yaml, record.image)
    write_layers(folder, build_layers(grid, robot_radius=robot_radius), record.created)


async def build_in_fork(record: MapRecord, robot_radius: float, folder: Path) -> None:
    """Make the layers of a map in a process forked from the fork server.

    Raises
    ------
    InvalidMap
        The files are no map.
    Unavailable
        There is no room, or the process was killed.
    """
    refusal = await asyncio.to_thread(_await_child, record, robot_radius, folder)
    if refusal is not None:
        raise rebuild(refusal.slug, refusal.text)


def _await_child(record: MapRecord, robot_radius: float, folder: Path) -> Refusal | None:
    receiving, sending = multiprocessing.Pipe(duplex=False)
    with receiving, sending:
        try:
            process = start_process(_build_and_tell, record, robot_radius, folder, sending)
            sending.close()
            answer: Refusal | None = receiving.recv()
        except (EOFError, OSError) as error:
            raise Unavailable(f"the process that made the layers of map {record.id!r} was lost; try again") from error
        status = process.wait()
        process.close()
    if status == UNHEARD:  # the fork server died meanwhile, and left the process to us
        with suppress(ChildProcessError):
            os.waitpid(process.pid, 0)
    return answer


def _build_and_tell(record: MapRecord, robot_radius: float, folder: Path, answer: Connection) -> None:
    die_with_parent()
    try:
        build_here(record, robot_radius, folder)
    except PPaaSError as error:
        answer.send(Refusal(error.slug, str(error)))
    else:
        answer.send(None)
