"""Module ``hardware`` of the examples: the simulated robot of docs/examples, whose true pose goes to the scorer.

The test copies it to a folder of its own, and names it the examples. The example receives only sensor data.
"""

import importlib.util
import json
import os
import threading
import time
from pathlib import Path

SCORER = Path(os.environ["SCORER"])
STEP = 0.02

found = importlib.util.spec_from_file_location(
    "simulation", Path(os.environ["EXAMPLES"]) / "simulation" / "hardware.py"
)
assert found is not None and found.loader is not None
simulation = importlib.util.module_from_spec(found)
found.loader.exec_module(simulation)
odometry, scan, drive = simulation.odometry, simulation.scan, simulation.drive


def _live() -> None:
    while True:
        with simulation.lock:
            truth = tuple(simulation.robot.base.pose)
        partial = SCORER.with_suffix(".partial")
        partial.write_text(json.dumps(truth))
        partial.rename(SCORER)
        time.sleep(STEP)


threading.Thread(target=_live, daemon=True).start()
