# mypy: ignore-errors
"""Program of a board with MicroPython: sends scans and odometry, and measures its own heap and pauses.

micropython -X heapsize=32k board_program.py PORT SECONDS

Prints one line of JSON.
"""

import gc
import json
import sys
import time

from ppaas_robot import Robot

BEAMS = 360
ODOMETRY_PERIOD = 50  # [ms]
counts = {"velocities": 0, "poses": 0, "collection": 0, "step": 0, "scan_bytes": 0, "scan_us": 0, "heap": 0}


def note(name, value):
    """Keep the largest value of a figure."""
    counts[name] = max(counts[name], value)


def drive(_vx, _vy, _wz):
    """Count a velocity."""
    counts["velocities"] += 1


def seen(_pose):
    """Count a message in JSON."""
    counts["poses"] += 1


def collect():
    """Note how long a collection takes, now that there is garbage [us]."""
    since = time.ticks_us()
    gc.collect()
    note("collection", time.ticks_diff(time.ticks_us(), since))
    note("heap", gc.mem_alloc())


def scan(robot):
    """Send a scan; note what it allocates [bytes] and takes [us]."""
    before, since = gc.mem_alloc(), time.ticks_us()
    robot.send_scan()
    counts["scan_us"] += time.ticks_diff(time.ticks_us(), since)
    note("scan_bytes", gc.mem_alloc() - before)


def run(robot, until):
    """Drive until a time [ms]."""
    ticks, due = 0, time.ticks_ms()
    while time.ticks_diff(until, time.ticks_ms()) > 0:
        since = time.ticks_us()
        robot.send_odom(1.0, 2.0, 0.5, 0.2, 0.0, 0.1)
        if ticks % 4 == 0:
            scan(robot)
        robot.poll()
        note("step", time.ticks_diff(time.ticks_us(), since))
        ticks += 1
        if ticks % 20 == 0:
            collect()
        due = time.ticks_add(due, ODOMETRY_PERIOD)
        time.sleep_ms(max(time.ticks_diff(due, time.ticks_ms()), 0))
    counts["scan_us"] = 4 * counts["scan_us"] / ticks


robot = Robot("127.0.0.1", int(sys.argv[1]), "board", "token", BEAMS, drive)
robot.laser(-3.14159265, 0.01745329, 120, 8000)
robot.subscribe("amcl_pose", seen)
for beam in range(BEAMS):
    robot.ranges[beam] = 1234 + beam
while not robot.poll():
    time.sleep_ms(10)
run(robot, time.ticks_add(time.ticks_ms(), int(sys.argv[2]) * 1000))
robot.leave()
counts["passed"] = robot.passed
print(json.dumps(counts))  # noqa: T201
