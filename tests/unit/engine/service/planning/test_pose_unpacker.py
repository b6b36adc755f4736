"""Poses are unpacked as soon as the kernels are loaded."""

import asyncio
import threading

import numpy as np
import pytest

from engine.service.planning import pose_unpacker
from engine.service.planning.pose_unpacker import PoseUnpacker
from ppaas.errors import MalformedMessage
from ppaas.plans.encoding.packed_poses import pack_poses, unpack_poses

POSES = np.arange(70.0).reshape(10, 7)


async def test_poses_are_unpacked_before_and_after_the_kernels_are_loaded() -> None:
    unpacker = PoseUnpacker()
    for _ in range(3):
        assert (await unpacker.unpack(pack_poses(POSES))).tobytes() == POSES.tobytes()
    with pytest.raises(MalformedMessage):
        await unpacker.unpack(b"x")


async def test_a_caller_that_gives_up_does_not_end_the_loading_for_others(monkeypatch: pytest.MonkeyPatch) -> None:
    may_load = threading.Event()

    def load() -> pose_unpacker.Unpack:
        may_load.wait()
        return unpack_poses

    monkeypatch.setattr(pose_unpacker, "_load", load)
    unpacker = PoseUnpacker()
    unpacker.begin()
    first, second = (asyncio.create_task(unpacker.unpack(pack_poses(POSES))) for _ in range(2))
    await asyncio.sleep(0)
    first.cancel()
    may_load.set()
    assert (await second).tobytes() == POSES.tobytes()
    assert first.cancelled()


async def test_kernels_that_could_not_be_loaded_are_loaded_at_the_next_path(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail() -> pose_unpacker.Unpack:
        raise OSError("no folder")

    unpacker = PoseUnpacker()
    with monkeypatch.context() as patch:
        patch.setattr(pose_unpacker, "_load", fail)
        with pytest.raises(OSError, match="no folder"):
            await unpacker.unpack(pack_poses(POSES))
    assert (await unpacker.unpack(pack_poses(POSES))).tobytes() == POSES.tobytes()
