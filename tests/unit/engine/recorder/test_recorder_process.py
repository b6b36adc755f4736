"""The recorder of a machine as a process: started for the first batch, started again, and ended with its agent."""

import asyncio
import signal
from pathlib import Path

import pytest

from engine.protocols.machine_link import RecorderTold
from engine.recorder import recorder_process
from engine.recorder.recorder_process import MISSING, NO_RECORDER, NOT_HERE, RecorderProcess
from engine.specs.containers import ContainerSpec, MapVersion, RobotConfig
from ppaas.recording.batches import Batch, batch_bytes
from storage.recordings import RecordingsFolder
from tests.support.recordings.entries import ABOUT, entry, read, scan
from tests.support.waiting import until

ID = "20261126T224142Z"
BATCH = batch_bytes(Batch(ABOUT, recording=ID, recording_topics=("*",), entries=[entry("scan", scan())]))


def clone(container: str = "c1") -> ContainerSpec:
    robot = RobotConfig("tb1", "turtlebot2", (0.0, 0.0, 0.0), "dijkstra", "dwa")
    return ContainerSpec(container, "ann", MapVersion("office", "v"), 1.0, robot=robot)


async def test_files_are_finished_when_the_agent_ends(tmp_path: Path) -> None:
    told: list[RecorderTold] = []
    recorder, folder = RecorderProcess(tmp_path, None), RecordingsFolder(tmp_path)
    assert recorder.pid is None
    while not folder.recordings("ann", "tb1"):
        recorder.take(clone(), BATCH, told.append)
        await asyncio.sleep(0.05)
    assert told[0].lost == 1  # it was not up yet
    assert RecorderTold(forgotten=True) in told
    await recorder.close()
    (stored,) = folder.recordings("ann", "tb1")
    reader, messages = read(stored.path.read_bytes())
    assert (stored.finished, reader.cut, bool(messages)) == (True, False, True)


async def test_recorder_that_was_killed_is_started_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(recorder_process, "RESTART_DELAY", 0.01)
    recorder, told = RecorderProcess(tmp_path, None), list[RecorderTold]()
    recorder.take(clone(), BATCH, told.append)
    await until(lambda: recorder.pid)
    first = recorder.pid
    assert recorder._process is not None
    recorder._process.send_signal(signal.SIGKILL)
    await until(lambda: recorder.pid not in (None, first))
    await recorder.close()


async def test_container_that_was_replaced_does_not_end_the_files_of_the_next(tmp_path: Path) -> None:
    recorder, folder = RecorderProcess(tmp_path, None), RecordingsFolder(tmp_path)
    while not folder.recordings("ann", "tb1"):
        recorder.take(clone("c1"), BATCH, lambda _: None)
        await asyncio.sleep(0.05)
    recorder.take(clone("c2"), BATCH, lambda _: None)
    recorder.left(clone("c1"))
    await asyncio.sleep(0.2)
    assert [one.finished for one in folder.recordings("ann", "tb1")] == [False]
    recorder.left(clone("c2"))
    await until(lambda: folder.recordings("ann", "tb1")[0].finished)
    await recorder.close()


async def test_missing_library_is_told_and_nothing_is_tried_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "mcap.py").write_text("raise ImportError")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    recorder, told = RecorderProcess(tmp_path, None), list[RecorderTold]()
    recorder.take(clone(), BATCH, told.append)
    await until(lambda: RecorderTold(MISSING) in told)
    await recorder.close()


def test_machine_without_a_folder_says_so() -> None:
    told: list[RecorderTold] = []
    NO_RECORDER.take(clone(), BATCH, told.append)
    NO_RECORDER.left(clone())
    assert told == [RecorderTold(NOT_HERE)]
