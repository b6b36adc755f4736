# mypy: ignore-errors
"""Program of a board with MicroPython, without our client: the same scan by ``json.dumps``.

micropython -X heapsize=256k json_program.py SCANS

Prints one line of JSON: the median time of a scan [us] and the memory that a scan allocates [bytes].
"""

import gc
import json
import sys
import time
from array import array

ranges = array("H", (1234 + beam for beam in range(360)))
times, most = [], 0
for _ in range(int(sys.argv[1])):
    gc.collect()
    before, since = gc.mem_alloc(), time.ticks_us()
    message = {"header": {"frame_id": ""}, "ranges": [beam / 1000 for beam in ranges]}
    text = json.dumps({"op": "publish", "topic": "scan", "msg": message})
    times.append(time.ticks_diff(time.ticks_us(), since))
    most = max(most, gc.mem_alloc() - before)
print(json.dumps({"us": sorted(times)[len(times) // 2], "bytes": most, "size": len(text)}))  # noqa: T201
