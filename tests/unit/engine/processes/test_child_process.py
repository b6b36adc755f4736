"""Child processes that run until their input ends."""

import asyncio
import signal
import sys
from asyncio.subprocess import PIPE

from engine.processes.child_process import end

DEAF = "import time; print('up', flush=True); time.sleep(60)"


async def test_process_exits_when_its_input_ends() -> None:
    process = await asyncio.create_subprocess_exec(sys.executable, "-c", "import sys; sys.stdin.read()", stdin=PIPE)
    await end(process, 30.0)
    assert process.returncode == 0


async def test_process_that_goes_on_is_killed() -> None:
    process = await asyncio.create_subprocess_exec(sys.executable, "-c", DEAF, stdin=PIPE, stdout=PIPE)
    assert process.stdout is not None
    await process.stdout.readline()
    await end(process, 0.01)
    assert process.returncode == -signal.SIGKILL
