# mypy: ignore-errors
"""MicroPython's client fed with what a hostile cloud sends, case by case.

Reads cases: a length (uint32), the size of the pieces in which they come (uint16), and the bytes. Writes for each a
line: empty, or what was raised.
"""

import io
import struct
import sys

from ppaas_robot import Refused, Robot


class Fed(io.IOBase):
    def __init__(self, data, piece):
        self.data, self.piece, self.at = memoryview(data), piece, 0

    def ioctl(self, request, argument):
        return argument if request == 3 else 0  # may be read and written

    def readinto(self, buffer):
        count = min(len(buffer), len(self.data) - self.at, self.piece)
        buffer[:count] = self.data[self.at : self.at + count]
        self.at += count
        return count

    def read(self, size):
        part = bytes(self.data[self.at : self.at + size])
        self.at += len(part)
        return part

    def readline(self):
        begin, data = self.at, self.data
        while self.at < len(data):
            self.at += 1
            if data[self.at - 1] == 10:
                break
        return bytes(data[begin : self.at])

    def write(self, data):
        return len(data)

    def setblocking(self, blocking):
        pass

    def close(self):
        self.at = len(self.data)


class FedRobot(Robot):
    def _dial(self):
        if self.fed is None:
            raise OSError("no connection")
        self.socket, self.fed = self.fed, None


def ignore(*_values):
    pass


def fed(data, piece):
    robot = FedRobot("host", 8500, "tb1", "t0ken", 3, ignore, 300)
    robot.on_status = ignore
    robot.laser(-1.0, 0.5, 120, 8000)
    robot.subscribe("amcl_pose", ignore)
    robot.fed = Fed(data, piece)
    try:
        for _ in range(8 + len(data) // 32):
            robot.poll()
            robot.send_scan()
    except Refused:
        pass


given, head = sys.stdin.buffer, bytearray(6)
while given.readinto(head) == 6:
    size, piece = struct.unpack("<IH", head)
    data = given.read(size)
    try:
        fed(data, piece or 1)
        raised = ""
    except Exception as error:  # noqa: BLE001 - whatever it is
        raised = repr(error).replace("\n", " ")
    sys.stdout.write(raised + "\n")
