/** Commands of a driver: they echo what was heard and seen, and enable nothing without both. */

import assert from "node:assert/strict";
import { test } from "node:test";
import { TeleopDriver } from "../../../../endpoints/dashboard/static/js/teleop_driver.js";

const AHEAD = { linear: 1, angular: 0 };
const state = (fields = {}) => ({ number: 1, id: "me", driver: "ada", mode: "ready", text: "", command: 0, max_linear: 0.5, max_angular: 1, command_timeout: 0.3, view_timeout: 1, ...fields });

/** A driver that has let go of the control at 1 s, and sees a pose of that time. */
function driving() {
  const driver = new TeleopDriver("me");
  driver.command(null, 0.9, 0.9);
  driver.heard(state({ number: 7, command: 1 }), 1);
  driver.command(null, 1, 1);
  return driver;
}

test("it requests to drive until it does", () => {
  const driver = new TeleopDriver("me");
  const { request, enable, echo, number } = driver.command(AHEAD, 0, 0);
  assert.deepEqual({ request, enable, echo, number }, { request: "drive", enable: false, echo: 0, number: 1 });
  assert.equal(driver.command(null, 0.05, 0).request, "drive");
  driver.heard(state(), 0.1);
  assert.equal(driver.command(null, 0.15, 0.1).request, "");
  assert.equal(driver.command(null, 0.2, 0.1).number, 4);
});

test("a command has the speed, the last state and the time since, and the state before the pose that is seen", () => {
  const driver = driving();
  driver.heard(state({ number: 8 }), 1.2);
  const command = driver.command({ linear: 0.5, angular: -1 }, 1.25, 1.1);
  assert.deepEqual([command.linear, command.angular], [0.25, -1]);
  assert.deepEqual([command.enable, command.echo, command.view], [true, 8, 7]);
  assert.ok(Math.abs(command.held - 0.05) < 1e-9);
});

test("letting go enables nothing, at once", () => {
  const driver = driving();
  assert.equal(driver.command(AHEAD, 1.05, 1).enable, true);
  const { enable, linear } = driver.command(null, 1.06, 1);
  assert.deepEqual([enable, linear], [false, 0]);
});

test("an old pose locks until the control is let go", () => {
  const driver = driving();
  driver.heard(state({ number: 8 }), 2.4);
  assert.equal(driver.command(AHEAD, 2.45, 1.2).enable, false);
  assert.match(driver.text(2.45, 1.2), /position on the map is old/);
  assert.equal(driver.command(AHEAD, 2.5, 2.5).enable, false, "the key is still held");
  driver.command(null, 2.55, 2.5);
  assert.equal(driver.command(AHEAD, 2.6, 2.5).enable, true);
});

test("a stalled link locks", () => {
  const driver = driving();
  assert.equal(driver.command(AHEAD, 1.6, 1.6).enable, false);
  assert.match(driver.text(1.6, 1.6), /link is stalled/);
});

test("a key that is held from the beginning does not drive", () => {
  const driver = new TeleopDriver("me");
  driver.command(AHEAD, 0, 0);
  driver.heard(state(), 0.1);
  assert.equal(driver.command(AHEAD, 0.15, 0.1).enable, false);
});

test("the round trip is from a command to the state that says that it was taken", () => {
  const driver = driving();
  const { number } = driver.command(AHEAD, 1.1, 1.1);
  driver.heard(state({ number: 8, command: number }), 1.13);
  assert.ok(driver.roundTrip > 0.02 && driver.roundTrip < 0.2);
});

test("while somebody else drives it sends nothing, unless it takes over", () => {
  const driver = new TeleopDriver("me");
  driver.heard(state({ id: "other", driver: "bob" }), 0.1);
  assert.equal(driver.command(AHEAD, 0.15, 0.1), null);
  assert.equal(driver.text(0.15, 0.1), "bob drives");
  driver.takeOver();
  assert.equal(driver.command(null, 0.2, 0.1).request, "take over");
});

test("one who lost the robot sends nothing more, and is told who has it", () => {
  const driver = driving();
  driver.heard(state({ id: "other", driver: "bob" }), 1.1);
  assert.equal(driver.command(AHEAD, 1.15, 1.1), null);
  assert.equal(driver.text(1.15, 1.1), "bob has taken over");
  assert.equal(driver.leaving(1.2), null);
});

test("a lapsed turn is not begun again by itself", () => {
  const driver = driving();
  driver.heard(state({ id: "", driver: "", mode: "free" }), 1.1);
  assert.equal(driver.command(AHEAD, 1.15, 1.1), null);
  assert.match(driver.text(1.15, 1.1), /no longer/);
  assert.equal(driver.mayTakeOver, true);
  driver.takeOver();
  assert.equal(driver.command(null, 1.2, 1.1).request, "take over");
});

test("a robot that is not driven by hand says why", () => {
  const driver = new TeleopDriver("me");
  driver.heard(state({ id: "", mode: "refused", text: "it follows paths itself" }), 0.1);
  assert.equal(driver.command(null, 0.15, 0.1), null);
  assert.match(driver.text(0.15, 0.1), /it follows paths itself/);
});

test("its last command leaves", () => {
  const { request, enable } = driving().leaving(1.2);
  assert.deepEqual([request, enable], ["leave", false]);
});
