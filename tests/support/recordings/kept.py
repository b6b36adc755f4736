"""A folder of recordings, and a recorder that answers, for services under test."""

import tempfile
from functools import cache
from pathlib import Path

from ppaas.messages.health.watching import RecorderState
from storage.recordings import RecordingsFolder
from tests.support.endpoints.fake_cloud import FakeCloud
from tests.support.recordings.entries import entry, mcap, scan

RECORDING = "20261126T224142Z"
"""Id of the recording in the folder."""


def kept_recordings(cloud: FakeCloud, user: str, robot: str) -> RecordingsFolder:
    """Return a folder in which a robot has a recording and a ring, and make its recorder answer."""
    folder = RecordingsFolder(Path(_temporary().name))
    files = folder.of_robot(user, robot)
    (files / "ring").mkdir(parents=True, exist_ok=True)
    recording = files / f"{RECORDING}.mcap"
    for file in (recording, files / "ring" / "1800000000000000000.mcap"):
        file.write_bytes(_file())

    def answer(service: str) -> RecorderState:
        if service != "start":
            return RecorderState()
        files.mkdir(parents=True, exist_ok=True)  # a test may have deleted the recording, or all of the robot
        recording.write_bytes(_file())
        return RecorderState(RECORDING)

    cloud.recorder = answer
    return folder


@cache
def _temporary() -> tempfile.TemporaryDirectory[str]:
    return tempfile.TemporaryDirectory(prefix="ppaas-recordings-")


@cache
def _file() -> bytes:
    return mcap(entry("scan", scan()))
