# mypy: ignore-errors
"""Robot in MicroPython whose body is simulated on the other side of its standard streams.

micropython -X heapsize=32k micropython_robot.py HOST PORT ROBOT TOKEN

Reads records of a letter and its data: ``o`` odometry (six float32), ``s`` a scan (360 uint16), ``r`` a request for a
report. Writes records of a letter: ``v`` a velocity (three float32), ``r`` a report (uint16 length, JSON).
"""

import gc
import json
import struct
import sys
import time

from ppaas_robot import Robot

host, port, name, token = sys.argv[1:]
out, given = sys.stdout.buffer, sys.stdin.buffer
errors = []
counts = {"scans": 0, "reconnects": -1, "resumed": 0, "poses": 0, "bytes": 0, "pause": 0}


def drive(vx, vy, wz):
    out.write(struct.pack("<Bfff", ord("v"), vx, vy, wz))


def seen(_pose):
    counts["poses"] += 1


def measured():
    # what a scan allocates [bytes], and how long a collection takes [ms]
    since = time.ticks_us()
    gc.collect()
    counts["pause"] = max(counts["pause"], time.ticks_diff(time.ticks_us(), since) / 1000)
    before = gc.mem_alloc()
    robot.send_scan()
    counts["bytes"] = gc.mem_alloc() - before


def report():
    measured()
    text = json.dumps(
        dict(counts, errors=errors, lost=str(robot.lost), received=robot.received, passed=robot.passed)
    ).encode()
    out.write(struct.pack("<BH", ord("r"), len(text)))
    out.write(text)


robot = Robot(host, int(port), name, token, 360, drive)
robot.on_status = errors.append
robot.laser(-3.14159265, 0.01745329, 120, 8000)
try:
    robot.subscribe("map", seen)
except ValueError as error:
    errors.append(str(error))
robot.subscribe("amcl_pose", seen, "geometry_msgs/PoseWithCovarianceStamped", 1000)
letter, odometry, connected = bytearray(1), bytearray(24), False
while given.readinto(letter):
    if letter == b"o":
        given.readinto(odometry)
        robot.send_odom(*struct.unpack("<6f", odometry))
    elif letter == b"s":
        given.readinto(robot.ranges)
        robot.send_scan()
        counts["scans"] += 1
    else:
        report()
    if robot.poll() and not connected:
        counts["reconnects"] += 1
        counts["resumed"] += robot.resumed
        if not robot.resumed:
            robot.say('{"op":"subscribe","topic":"map"}')  # all the same: it is passed over
    connected = robot.socket is not None
