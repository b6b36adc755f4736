/** Keys, pad and gamepad as motions, and none once they are let go. */

import assert from "node:assert/strict";
import { test } from "node:test";
import { drives, motionOfGamepads, motionOfKeys, motionOfTouch } from "../../../../endpoints/dashboard/static/js/teleop_input.js";

const PAD = { left: 100, top: 50, width: 200, height: 200 };
const gamepad = (held, axes, connected = true) => ({ connected, axes, buttons: Array.from({ length: 6 }, (_, i) => ({ pressed: i === 4 && held })) });

test("keys drive, and those that are held together add up", () => {
  assert.deepEqual(motionOfKeys(new Set(["KeyW"])), { linear: 1, angular: 0 });
  assert.deepEqual(motionOfKeys(new Set(["ArrowUp", "ArrowLeft"])), { linear: 1, angular: 1 });
  assert.deepEqual(motionOfKeys(new Set(["KeyW", "KeyS"])), { linear: 0, angular: 0 });
  assert.deepEqual(motionOfKeys(new Set(["KeyW", "ArrowUp", "KeyD"])), { linear: 1, angular: -1 });
});

test("no key that drives is no motion", () => {
  assert.equal(motionOfKeys(new Set()), null);
  assert.equal(motionOfKeys(new Set(["KeyQ"])), null);
  assert.equal(drives("KeyQ") || drives("toString"), false);
});

test("a finger drives forward above the middle of the pad, and turns beside it", () => {
  assert.deepEqual(motionOfTouch({ x: 200, y: 50 }, PAD), { linear: 1, angular: 0 });
  assert.deepEqual(motionOfTouch({ x: 100, y: 150 }, PAD), { linear: 0, angular: 1 });
  assert.deepEqual(motionOfTouch({ x: 900, y: 900 }, PAD), { linear: -1, angular: -1 });
  assert.deepEqual(motionOfTouch({ x: 205, y: 145 }, PAD), { linear: 0, angular: 0 });
  assert.equal(motionOfTouch(null, PAD), null);
});

test("a gamepad drives only while a shoulder button is held, and not once it is unplugged", () => {
  assert.deepEqual(motionOfGamepads([null, gamepad(true, [1, -1])]), { linear: 1, angular: -1 });
  assert.deepEqual(motionOfGamepads([gamepad(true, [0.05, -0.1])]), { linear: 0, angular: 0 });
  assert.equal(motionOfGamepads([gamepad(false, [1, -1])]), null);
  assert.equal(motionOfGamepads([gamepad(true, [1, -1], false)]), null);
  assert.equal(motionOfGamepads([null]), null);
});
