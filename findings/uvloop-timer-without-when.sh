#!/usr/bin/env bash
# WITH uvloop 0.23.0 from PyPI, CPython 3.11 or newer on Linux
# EXPECTED loop.call_later and loop.call_at return asyncio.TimerHandle, which has when(), as asyncio documents.
# SEEN a delay that rounds to 0 ms (less than half a millisecond) gives a plain Handle without when(); from then on a
#   TimerHandle. asyncio's loop returns a TimerHandle for any delay.
# HERE The due time is kept beside the handle, and when() is not called (engine/sessions/).
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
{ python3 -m venv "$folder/venv" && "$folder/venv/bin/pip" install -q uvloop==0.23.0; } >"$folder/log" 2>&1 || {
    tail -n 1 "$folder/log"
    exit 2
}

"$folder/venv/bin/python" <<'PYTHON'
import asyncio
import sys

import uvloop

DELAYS = (0.0, 0.0004, 0.0006, 0.002)


async def timers() -> list[bool]:
    """Return for each delay whether the handle has when()."""
    loop = asyncio.get_running_loop()
    handles = [loop.call_later(delay, lambda: None) for delay in DELAYS]
    return [hasattr(handle, "when") for handle in handles]


with asyncio.Runner() as usual, asyncio.Runner(loop_factory=uvloop.new_event_loop) as uv:
    seen = usual.run(timers()), uv.run(timers())
for name, found in zip(("asyncio", "uvloop"), seen, strict=True):
    print(name, {f"{delay * 1e3:g} ms": "when()" if has else "no when()" for delay, has in zip(DELAYS, found, strict=True)})
sys.exit(seen != ([True] * 4, [False, False, True, True]))
PYTHON
