import assert from "node:assert/strict";
import test from "node:test";

import { poseMessage } from "../../../../endpoints/dashboard/static/js/geometry.js";
import { framesOf, goalOf, pathOf, posesOf, scanOf, secondsOf } from "../../../../endpoints/dashboard/static/js/messages.js";
import { RobotState, SILENCE } from "../../../../endpoints/dashboard/static/js/robot_state.js";

const stamped = (secs) => ({ stamp: { secs, nsecs: 0 } });
const localized = (secs, pose) => ({ header: stamped(secs), pose: { pose: poseMessage(pose) } });
const scan = (secs, frame_id = "base_link") => ({
  header: { ...stamped(secs), frame_id }, angle_min: 0, angle_increment: Math.PI / 2, range_min: 0.1, range_max: 10,
  ranges: [2, null, 0.05, 3],
});
const status = (code, text = "") => ({ status: code, text, goal_id: { id: "g" } });
const round = (points) => [...points].map((value) => Math.round(value * 1e4) / 1e4 + 0);

test("stamps are read in both spellings", () => {
  assert.equal(secondsOf({ secs: 2, nsecs: 5e8 }), 2.5);
  assert.equal(secondsOf({ sec: 2, nanosec: 5e8 }), 2.5);
  assert.equal(secondsOf(undefined), 0);
});

test("what is no reading is no point", () => {
  assert.deepEqual(round(scanOf(scan(0))), [2, 0, 0, -3]);
  assert.deepEqual(round(scanOf({})), []);
});

test("paths and particles leave out what is no pose", () => {
  const poses = [poseMessage({ x: 1, y: 2, theta: 0 }), { position: null }];
  assert.deepEqual(round(posesOf({ poses })), [1, 2, 0]);
  assert.deepEqual(round(pathOf({ poses: poses.map((pose) => ({ pose })) })), [1, 2]);
  assert.deepEqual(round(pathOf({})), []);
});

test("a scan waits for the pose that it was taken at", () => {
  const state = new RobotState();
  state.take("amcl_pose", localized(1, { x: 0, y: 0, theta: 0 }), 1);
  state.take("scan", scan(2), 2);
  assert.equal(state.scan.length, 0);
  state.take("amcl_pose", localized(1.5, { x: 9, y: 9, theta: 0 }), 2);
  assert.equal(state.scan.length, 0);
  state.take("amcl_pose", localized(2, { x: 1, y: 0, theta: Math.PI / 2 }), 2);
  assert.deepEqual(round(state.scan), [1, 2, 4, 0]);
});

test("a scan of a laser begins where the laser is on the base", () => {
  const state = new RobotState();
  const transform = { translation: { x: 0.5, y: 0, z: 0 }, rotation: { x: 0, y: 0, z: 0, w: 1 } };
  state.take("tf_static", { transforms: [{ header: { frame_id: "base_link" }, child_frame_id: "/base_scan", transform }] }, 0);
  state.take("scan", scan(1, "base_scan"), 1);
  state.take("amcl_pose", localized(1, { x: 0, y: 0, theta: 0 }), 1);
  assert.deepEqual(round(state.scan), [2.5, 0, 0.5, -3]);
});

test("a laser upside down on a mount is drawn mirrored, where it is", () => {
  const state = new RobotState();
  const link = (parent, child, x, rotation) => ({
    header: { frame_id: parent }, child_frame_id: child, transform: { translation: { x, y: 0, z: 0 }, rotation },
  });
  const level = { x: 0, y: 0, z: 0, w: 1 };
  state.take("tf_static", { transforms: [link("base_footprint", "base_link", 9, level)] }, 0);
  state.take("tf_static", { transforms: [link("base_link", "mount", 0.3, level)] }, 0);
  state.take("tf_static", { transforms: [link("mount", "laser", 0.2, { x: 1, y: 0, z: 0, w: 0 })] }, 0);
  state.take("scan", scan(1, "laser"), 1);
  state.take("amcl_pose", localized(1, { x: 0, y: 0, theta: 0 }), 1);
  assert.deepEqual(round(state.scan), [2.5, 0, 0.5, 3]);
});

test("scans that are ahead of the poses are kept until these have come", () => {
  const state = new RobotState();
  for (const secs of [2, 3, 4]) state.take("scan", scan(secs), 1);
  state.take("amcl_pose", localized(3, { x: 1, y: 0, theta: 0 }), 3);
  assert.deepEqual(round(state.scan), [3, 0, 1, -3]);
  state.take("amcl_pose", localized(4, { x: 2, y: 0, theta: 0 }), 4);
  assert.deepEqual(round(state.scan), [4, 0, 2, -3]);
});

test("a range of 0 or range_min is no reading", () => {
  const zeros = { ...scan(0), range_min: 0, ranges: [0, 2, 0, 0] };
  assert.deepEqual(round(scanOf(zeros)), [0, 2]);
  assert.deepEqual(round(scanOf({ ...scan(0), ranges: [0.1, 2] })), [0, 2]);
});

test("a goal is followed from its way to its end", () => {
  const state = new RobotState();
  state.take("amcl_pose", localized(1, { x: 0, y: 0, theta: 0 }), 1);
  state.take("move_base/status", { status_list: [status(3, "before"), status(1)] }, 1);
  const path = { poses: [{ x: 0, y: 0, theta: 0 }, { x: 3, y: 4, theta: 0 }].map((pose) => ({ pose: poseMessage(pose) })) };
  state.take("plan", path, 1);
  assert.deepEqual(state.destination, { x: 3, y: 4 });
  assert.equal(state.remaining, 5);
  state.take("move_base/current_goal", { pose: poseMessage({ x: 3, y: 4, theta: 1 }) }, 1);
  assert.ok(Math.abs(state.destination.theta - 1) < 1e-9);
  const ended = state.take("move_base/result", { status: status(4, "no way") }, 2);
  assert.deepEqual([ended.word, ended.text, ended.id], ["gave up", "no way", "g"]);
  assert.deepEqual([state.destination, state.remaining, state.path.length], [null, null, 0]);
});

test("the end of a goal does not end the one that took its place", () => {
  const state = new RobotState();
  state.take("move_base/status", { status_list: [{ ...status(1), goal_id: { id: "new" } }] }, 1);
  state.take("move_base/current_goal", { pose: poseMessage({ x: 3, y: 4, theta: 1 }) }, 1);
  assert.equal(state.take("move_base/result", { status: status(2) }, 1).word, "stopped");
  assert.equal(state.goal.word, "driving");
  assert.equal(state.destination.x, 3);
});

test("a robot that says nothing for a while is silent", () => {
  const state = new RobotState();
  assert.ok(state.silent(0));
  state.take("amcl_pose", localized(1, { x: 0, y: 0, theta: 0 }), 10);
  assert.ok(!state.silent(10 + SILENCE));
  assert.ok(state.silent(10.1 + SILENCE));
});

test("messages that are none change nothing and break nothing", () => {
  const state = new RobotState();
  const topics = ["amcl_pose", "scan", "plan", "particlecloud", "tf_static", "move_base/status", "move_base/result", "move_base/current_goal", "other"];
  for (const topic of topics) for (const message of [{}, { poses: [{}] }, { transforms: [{}] }, { pose: 3 }]) state.take(topic, message, 0);
  state.take("amcl_pose", localized(1, { x: 0, y: 0, theta: 0 }), 1);
  assert.equal(state.goal, null);
  assert.equal(goalOf({ status: 99 }), null);
  assert.equal(framesOf({}).size, 0);
});

test("a robot that makes a map is where its mapping says, and shows the map so far", () => {
  const state = new RobotState();
  state.take("pose", localized(1, { x: 1, y: 2, theta: 0 }), 1);
  assert.deepEqual([state.pose.x, state.pose.y], [1, 2]);
  const origin = poseMessage({ x: 0, y: 0, theta: 0 });
  state.take("map", { info: { resolution: 1, width: 1, height: 1, origin }, data: [100] }, 1);
  state.take("map_updates", { x: 0, y: 0, width: 1, height: 1, data: [0] }, 1);
  assert.deepEqual([...state.map.grid.cells], [0]);
});

test("an exploration is shown until its result", () => {
  const state = new RobotState();
  state.take("explore/feedback", { feedback: { frontiers: 3, area: 12.5, text: "drives to a frontier" } }, 1);
  assert.deepEqual(state.exploration, { frontiers: 3, area: 12.5, text: "drives to a frontier" });
  assert.equal(state.take("explore/result", { status: status(3) }, 2).word, "has explored all it can reach");
  assert.equal(state.exploration, null);
});
