/** Sockets of robots: opened by an address that comes later, and not at all if nobody wants them by then. */

import assert from "node:assert/strict";
import { beforeEach, test } from "node:test";
import { RobotLink } from "../../../../endpoints/dashboard/static/js/robot_link.js";

const READY = { state: "ready", connected: true };
let sockets = [];

class FakeSocket {
  static CONNECTING = 0;
  static OPEN = 1;
  readyState = 0;

  constructor(url) {
    this.url = url;
    sockets.push(this);
  }

  close() {
    this.closed = true;
  }

  send() {}
}

globalThis.WebSocket = FakeSocket;

const events = { changed: () => {}, ended: () => {}, told: () => {} };
const link = () => new RobotLink({ id: "tb1", map: "office", model: "m", radius: 0.2, colour: 0 }, new Set(), events);

/** Addresses that are given when the test says so. */
function addresses() {
  const asked = [];
  return { asked, urlOf: (robot) => new Promise((give, refuse) => asked.push({ robot, give, refuse })) };
}

const settled = () => new Promise((resolve) => setTimeout(resolve, 0));

/** A robot whose socket is being opened. */
async function connecting() {
  const { asked, urlOf } = addresses();
  const robot = link();
  robot.placed(READY, urlOf);
  asked[0].give("ws://cloud/?ticket=1");
  await settled();
  return { robot, asked, urlOf };
}

/** Open a socket. */
function opened(socket) {
  socket.readyState = FakeSocket.OPEN;
  socket.onopen();
}

beforeEach(() => {
  sockets = [];
});

test("a socket is opened at an address of its own, asked for once", async () => {
  const { asked, urlOf } = addresses();
  const robot = link();
  for (let poll = 0; poll < 3; poll++) robot.placed(READY, urlOf);
  assert.deepEqual(asked.map((each) => each.robot), ["tb1"]);
  asked[0].give("ws://cloud/?ticket=1");
  await settled();
  robot.placed(READY, urlOf);
  assert.deepEqual(sockets.map((socket) => socket.url), ["ws://cloud/?ticket=1"]);
  assert.equal(asked.length, 1);
});

test("a robot that lost its container meanwhile gets no socket", async () => {
  const { asked, urlOf } = addresses();
  const robot = link();
  robot.placed(READY, urlOf);
  robot.placed(undefined, urlOf);
  robot.placed(READY, urlOf);
  asked[0].give("ws://cloud/?ticket=old");
  asked[1].give("ws://cloud/?ticket=new");
  await settled();
  assert.deepEqual(sockets.map((socket) => socket.url), ["ws://cloud/?ticket=new"]);
});

test("a container that waits for its robot does not make the robot present", () => {
  const { urlOf } = addresses();
  const robot = link();
  assert.deepEqual([robot.presence, robot.waits], ["offline", false]);
  robot.placed({ state: "starting", connected: true }, urlOf);
  assert.equal(robot.presence, "starting");
  robot.placed(READY, urlOf);
  assert.notEqual(robot.presence, "offline");
  robot.placed({ state: "ready", connected: false }, urlOf);
  assert.deepEqual([robot.presence, robot.waits], ["offline", true]);
});

test("a refused address is not asked for again at once", async () => {
  const { asked, urlOf } = addresses();
  const robot = link();
  robot.placed(READY, urlOf);
  asked[0].refuse(new Error("the cloud does not answer"));
  await settled();
  robot.placed(READY, urlOf);
  assert.equal(asked.length, 1);
  assert.equal(sockets.length, 0);
});

test("a lost socket is followed by another address", async () => {
  const { robot, asked, urlOf } = await connecting();
  const now = performance.now;
  try {
    sockets[0].onclose({ reason: "" });
    performance.now = () => now.call(performance) + 10_000;
    robot.placed(READY, urlOf);
  } finally {
    performance.now = now;
  }
  assert.equal(asked.length, 2);
});

test("a socket that is no longer wanted is closed once it is open, and its robot is not heard", async () => {
  const { robot } = await connecting();
  robot.close();
  assert.equal(sockets[0].closed, undefined, "browsers log an error for a socket that is closed before it is open");
  opened(sockets[0]);
  assert.ok(sockets[0].closed);
  assert.ok(!robot.connected);
});

test("an open socket is closed at once", async () => {
  const { robot } = await connecting();
  opened(sockets[0]);
  robot.close();
  assert.ok(sockets[0].closed);
});
