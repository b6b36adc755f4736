"""The real executor process starts, answers, dies and is stopped."""

import asyncio
import os
import signal

import msgspec
import psutil
import pytest

from ppaas.errors import NotFound, Unavailable
from robots.onboard.executor import protocol
from robots.onboard.node_process import NodeProcess
from tests.unit.robots.onboard.executor.test_local_executor import CONFIG, MAP


async def test_a_killed_process_is_reported_and_fails_its_pending_calls() -> None:
    ended, messages = asyncio.Event(), []
    process = NodeProcess(messages.append, ended.set)
    assert (process.alive, process.pid) == (False, None)
    await process.start(protocol.Begin(CONFIG, MAP))
    assert os.getpgid(process.pid or 0) != os.getpgid(0), "a Ctrl-C does not reach it"
    added = await process.ask(protocol.Add("waypoint_follower", ""), protocol.Added)
    assert added.node == "waypoint_follower"
    with pytest.raises(NotFound, match="unknown node 'amcl'"):
        await process.ask(protocol.Remove("amcl"), protocol.Removed)
    for _ in range(2):
        with pytest.raises(TimeoutError):
            await asyncio.wait_for(process.ask(protocol.AskStates(), protocol.States), 0.0)
        waiting = asyncio.create_task(process.ask(protocol.AskStates(), protocol.States))
        await asyncio.sleep(0)
        await asyncio.sleep(0)
        waiting.cancel()
    removed = await process.ask(protocol.Remove("waypoint_follower"), protocol.Removed)
    assert removed.node == "waypoint_follower", "the answer of a cancelled request is discarded"
    assert process.alive
    assert process.pid is not None
    await process.ask(protocol.Add("move_base", ""), protocol.Added)
    clear = [process.call("move_base/clear_costmaps", b"{}") for _ in range(3)]
    assert await asyncio.gather(*clear) == [msgspec.Raw(b"{}")] * 3, "calls run concurrently, unlike requests"
    with pytest.raises(NotFound, match="unknown service 'amcl/nothing'"):
        await process.call("amcl/nothing", b"{}")
    with pytest.raises(Unavailable, match="did not answer within 0 s"):
        await process.call("move_base/clear_costmaps", b"{}", 0.0)
    asking = asyncio.create_task(process.ask(protocol.AskStates(), protocol.States, 30.0))
    calling = asyncio.create_task(process.call("move_base/clear_costmaps", b"{}"))
    os.kill(process.pid, signal.SIGSTOP)
    await asyncio.sleep(0)
    os.kill(process.pid, signal.SIGKILL)
    with pytest.raises(Unavailable, match="has exited"):
        await asking
    with pytest.raises(Unavailable, match="has exited"):
        await calling
    await asyncio.wait_for(ended.wait(), 10)
    assert not process.alive
    with pytest.raises(Unavailable, match="is not running"):
        await process.ask(protocol.AskStates(), protocol.States)
    with pytest.raises(Unavailable, match="is not running"):
        await process.call("move_base/clear_costmaps", b"{}")
    process.tell("odom", b"{}")
    await process.stop()


async def test_an_invalid_map_is_refused_and_stop_ends_the_process() -> None:
    process = NodeProcess(lambda _: None, lambda: None)
    with pytest.raises(Exception, match="OccupancyGrid"):
        await process.start(protocol.Begin(CONFIG, msgspec.Raw(b"[]")))
    pid = process.pid
    await process.stop()
    assert pid is not None
    assert not psutil.pid_exists(pid)
