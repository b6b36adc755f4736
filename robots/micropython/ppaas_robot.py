# mypy: ignore-errors
"""Client of PPaaS for MicroPython."""
# The only docstring, since a board keeps in its memory what it compiles: comments cost nothing. See
# docs/microcontrollers.md for an example, and docs/protocol.md for the protocol.
#
# Scans, odometry and velocities are compact frames, all else is JSON. A scan is sent from the array in which the robot
# measures it, and allocates nothing. Messages that are longer than the buffer are passed over in pieces.

import binascii
import json
import os
import select
import socket
import struct
import time
from array import array

import uctypes

STALE = 500  # [ms] without cmd_vel after which the robot is stopped
SILENT = 20000  # [ms] without a byte of the cloud, which pings every 5 s, after which the connection is lost
PATIENCE = 5000  # [ms] for which a write or a part of the handshake may take
LARGE = (
    "map", "map_updates", "plan", "local_plan", "particlecloud", "key_frames", "cloud_in", "octomap_binary",
    "octomap_full", "projected_map", "robot_description",
)  # fmt: skip


class Refused(Exception):
    pass


class Robot:
    # beams: ranges of a scan; drive: called with vx, vy [m/s], wz [rad/s] for each velocity, and with zeros when none
    # came in time or the connection is lost; inbox: longest message that is read [bytes]; tls: an SSLContext
    def __init__(self, host, port, robot, token, beams, drive, inbox=1024, session="board", tls=None):
        self.address, self.robot, self.token, self.session, self.tls = (host, port), robot, token, session, tls
        self.drive, self.topics, self.on_status = drive, {}, print
        self.ranges = array("H", bytes(2 * beams))  # [mm]; 0: no reading, 65535: nothing within reach
        self._ranges = uctypes.bytearray_at(uctypes.addressof(self.ranges), 2 * beams)
        self._scan, self._odom, self._frame, self.beams = bytearray(28), bytearray(38), bytearray(8), beams
        self._inbox, self._head, self._name = bytearray(inbox), bytearray(10), b""
        self._view = memoryview(self._inbox)
        self.socket = self.id = None
        self.resumed, self.received, self.passed, self.moving, self.retry = False, 0, 0, False, 0
        self.again = self._driven = time.ticks_ms()
        self.lost = "not connected"

    # -- to the cloud

    # angles [rad], ranges [mm], frame: the laser's; once, before the first scan
    def laser(self, angle_min, step, nearest, farthest, frame=""):
        self._name = frame.encode()
        size = 20 + 2 * self.beams + len(self._name)
        if size < 126:  # the head of a short frame is shorter
            struct.pack_into(">BBI", self._scan, 2, 0x82, 0x80 | size, 0)
        else:
            struct.pack_into(">BBHI", self._scan, 0, 0x82, 0xFE, size, 0)
        self._scan_head = memoryview(self._scan)[2 if size < 126 else 0 :]
        struct.pack_into("<BBH", self._scan, 8, 1, len(self._name), self.beams)
        struct.pack_into("<ffHH", self._scan, 16, angle_min, step, nearest, farthest)

    def send_scan(self, stamp=0):
        struct.pack_into("<I", self._scan, 12, stamp)
        if self._send(self._scan_head) and self._send(self._ranges) and self._name:
            self._send(self._name)

    # pose in the frame of odometry [m, rad], velocity of the robot [m/s, rad/s], stamp of the scans' clock [ms]
    def send_odom(self, x, y, yaw, vx, vy, wz, stamp=0):
        struct.pack_into(">BBIBB", self._odom, 0, 0x82, 0xA0, 0, 2, 0)
        struct.pack_into("<HI6f", self._odom, 8, 6, stamp, x, y, yaw, vx, vy, wz)
        self._send(self._odom)

    # any operation of rosbridge, as a dictionary or as JSON
    def say(self, operation):
        text = operation if isinstance(operation, (str, bytes)) else json.dumps(operation)
        data = text.encode() if isinstance(text, str) else text
        return self._send(self._ws_head(0x81, len(data))) and self._send(data)

    # handler: called with each message of the topic that is not longer than the inbox
    def subscribe(self, topic, handler, kind=None, throttle_rate=0):
        topic = topic.lstrip("/")
        if topic in LARGE or topic.endswith("costmap"):
            raise ValueError("%s is too large for this board" % topic)
        self.topics[topic] = (handler, kind, throttle_rate)
        if self.socket:
            self._ask(topic)

    def _ask(self, topic):
        _, kind, throttle = self.topics[topic]
        self.say({"op": "subscribe", "topic": topic, "id": topic, "type": kind, "throttle_rate": throttle})

    # Head of a frame. Its mask is zeros, so that nothing need be masked.
    def _ws_head(self, first, size):
        frame = self._frame
        if size < 126:
            struct.pack_into(">BBI", frame, 0, first, 0x80 | size, 0)
            return memoryview(frame)[:6]
        struct.pack_into(">BBHI", frame, 0, first, 0xFE, size, 0)
        return memoryview(frame)[:8]

    # whether all was written; if not, the connection is lost
    def _send(self, data):
        if not self.socket:
            return False
        try:
            at, size = self.socket.write(data) or 0, len(data)
            since = time.ticks_ms()
            while at < size:
                if time.ticks_diff(time.ticks_ms(), since) > PATIENCE:
                    raise OSError("the cloud does not read")
                self._poll.poll(10)
                at += self.socket.write(memoryview(data)[at:]) or 0
            return True
        except OSError as error:
            self.close(error)
            return False

    # -- from the cloud

    # Read what came, stop a robot that hears nothing, connect again: call it at least ten times a second.
    def poll(self):
        now = time.ticks_ms()
        if not self.socket:
            if time.ticks_diff(now, self.again) >= 0:
                self._connect()
        else:
            try:
                while self.socket and self._receive():
                    pass
                if time.ticks_diff(now, self._heard) > SILENT:
                    raise OSError("the cloud is silent")
            except OSError as error:
                self.close(error)
        if time.ticks_diff(now, self._driven) > STALE:
            self._stop()
        return self.socket is not None

    def _stop(self):
        if self.moving:
            self.moving = False
            self.drive(0.0, 0.0, 0.0)

    def close(self, reason="closed"):
        if self.socket:
            self.socket.close()
            self.socket, self.lost = None, reason
            self.again = time.ticks_add(time.ticks_ms(), self.retry)
            self.retry = min(2 * self.retry + 250, 8000)
            self._stop()

    # The robot will not come back: the cloud need not keep its session.
    def leave(self):
        if self._send(self._ws_head(0x88, 6)):
            self._send(b"\x03\xe8left")
        self.close("left")
        self.id = None

    # Read a part of a frame; return whether there may be more.
    def _receive(self):
        if self._at < self._need:  # the head
            count = self.socket.readinto(memoryview(self._head)[self._at : self._need])
            if not self._came(count):
                return False
            self._at += count
            if self._at == 2:
                size = self._head[1] & 127
                self._need = 2 if size < 126 else 4 if size == 126 else 10
            if self._at == self._need:
                head = self._head
                self._size = head[1] & 127 if self._need == 2 else int.from_bytes(head[2 : self._need], "big")
                self._got = 0
                if not self._size:
                    self._taken()
            return True
        room = len(self._inbox)
        keep = self._size <= room
        begin = self._got if keep else 0
        count = self.socket.readinto(self._view[begin : min(begin + self._size - self._got, room)])
        if not self._came(count):
            return False
        self._got += count
        if self._got == self._size:
            self._taken()
        return True

    def _came(self, count):
        if count is None:
            return False
        if not count:
            raise OSError("the cloud closed the connection")
        self._heard = time.ticks_ms()
        return True

    # Handle a complete frame.
    def _taken(self):
        opcode, size, keep = self._head[0] & 15, self._size, self._size <= len(self._inbox)
        self._at, self._need = 0, 2
        if opcode < 3:
            self.received, self.retry, self.passed = self.received + 1, 0, self.passed + (not keep)
        if opcode == 9 and keep and self._send(self._ws_head(0x8A, size)):
            self._send(self._view[:size])
        elif opcode == 8:
            self._send(self._ws_head(0x88, 0))
            told = keep and size > 1
            code = struct.unpack_from(">H", self._inbox)[0] if told else 1005
            self._closed(code, text_of(self._view[2:size]) if told else "")
        elif opcode == 2 and size == 20 and self._inbox[0] == 3:
            self._driven, self.moving = time.ticks_ms(), True
            self.drive(*struct.unpack_from("<3f", self._inbox, 8))
        elif opcode == 1 and keep:
            try:
                self._heard_json(json.loads(self._view[:size]))
            except (ValueError, MemoryError) as error:
                self.on_status("a message is lost: %s" % error)

    def _heard_json(self, message):
        op = message.get("op") if isinstance(message, dict) else None
        if op == "publish":
            entry = self.topics.get(str(message.get("topic")))
            if entry and "msg" in message:
                entry[0](message["msg"])
        elif op == "status":
            self.on_status(message.get("msg"))

    def _closed(self, code, reason):
        self.close("%d %s" % (code, reason))
        if code in (1008, 4409) or (code == 1011 and not reason.startswith(("unavailable", "idle"))):
            raise Refused(self.lost)

    # -- connections

    def _connect(self):
        resume = "%s.%d" % (self.id, self.received) if self.id else "none"
        path = "/?robot=%s&status=1&compact=1&session=%s&resume=%s" % (self.robot, self.session, resume)
        key = binascii.b2a_base64(os.urandom(16)).strip().decode()
        try:
            self.socket = socket.socket()
            self._dial()
            self.socket.write(
                "GET %s HTTP/1.1\r\nHost: %s:%d\r\nAuthorization: Bearer %s\r\nUpgrade: websocket\r\n"
                "Connection: Upgrade\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: %s\r\n\r\n"
                % ((path,) + self.address + (self.token, key))
            )
            self._greeted()
        except (OSError, ValueError, IndexError, MemoryError) as error:  # the last three: what answers is no cloud
            self.close(error)

    def _dial(self):
        self.socket.settimeout(PATIENCE / 1000)
        self.socket.connect(socket.getaddrinfo(*self.address)[0][-1])
        if self.tls:
            self.socket = self.tls.wrap_socket(self.socket, server_hostname=self.address[0])

    def _greeted(self):
        status, headers = read_head(self.socket)
        if status != 101:
            reason = "%d %s" % (status, self.socket.read(max(min(int(headers.get("content-length", 0)), 512), 0)))
            self.close(reason)
            if status in (400, 401, 403, 404, 422):
                raise Refused(reason)
            return
        self.resumed = headers.get("ppaas-session") == "resumed"
        if not self.resumed:
            self.id, self.received = headers.get("ppaas-session-id"), 0
        self.socket.setblocking(False)
        self._poll = select.poll()
        self._poll.register(self.socket, select.POLLOUT)
        self._at, self._need, self._size, self._got = 0, 2, 0, 0
        self._heard = self._driven = time.ticks_ms()
        if not self.resumed:
            self.say('{"op":"subscribe","topic":"cmd_vel","type":"geometry_msgs/Twist"}')
            for topic in self.topics:
                self._ask(topic)


# text in UTF-8; empty if it is none
def text_of(data):
    try:
        return bytes(data).decode()
    except ValueError:
        return ""


# status and headers, with names in lower case, of an HTTP response
def read_head(stream):
    line = stream.readline()
    if not line:
        raise OSError("the cloud closed the connection")
    status, headers = int(line.split()[1]), {}
    while True:
        name, _, value = stream.readline().decode().partition(":")
        if not value:
            return status, headers
        headers[name.lower()] = value.strip()


# token of a user, by name and password
def login(host, port, user, password, tls=None):
    stream = socket.socket()
    stream.connect(socket.getaddrinfo(host, port)[0][-1])
    stream = tls.wrap_socket(stream, server_hostname=host) if tls else stream
    body = json.dumps({"user": user, "password": password})
    stream.write(
        "POST /v1/tokens HTTP/1.0\r\nHost: %s:%d\r\nContent-Type: application/json\r\nContent-Length: %d\r\n\r\n%s"
        % (host, port, len(body), body)
    )
    status, _ = read_head(stream)
    answer = stream.read(1024)
    stream.close()
    if status >= 300:
        raise Refused("%d %s" % (status, answer))
    return json.loads(answer)["token"]
