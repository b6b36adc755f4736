import assert from "node:assert/strict";
import test from "node:test";

import { compose, lengthOf, place, placeAll, poseMessage, poseOf, wrap, yawOf } from "../../../../endpoints/dashboard/static/js/geometry.js";

const near = (a, b) => assert.ok(Math.abs(a - b) < 1e-6, `${a} is not ${b}`);

test("a pose comes back from its message", () => {
  for (const theta of [-3.1, -1, 0, 0.5, 3.1]) near(poseOf(poseMessage({ x: 1, y: 2, theta })).theta, theta);
});

test("the yaw of a quaternion that tilts too is that about z", () => {
  near(yawOf({ x: 0, y: 0, z: Math.SQRT1_2, w: Math.SQRT1_2 }), Math.PI / 2);
});

test("what is no pose is none", () => {
  for (const bad of [null, undefined, {}, { position: { x: 1, y: 1 } }, { position: { x: null, y: 0 }, orientation: { z: 0, w: 1 } }]) {
    assert.equal(poseOf(bad), null);
  }
});

test("angles are wrapped to one turn", () => {
  near(wrap(3 * Math.PI), Math.PI);
  near(wrap(-Math.PI), Math.PI);
  near(wrap(7), 7 - 2 * Math.PI);
});

test("points and poses go out of a frame that is turned", () => {
  const frame = { x: 1, y: 2, theta: Math.PI / 2 };
  const { x, y } = place(frame, { x: 3, y: 0 });
  near(x, 1);
  near(y, 5);
  near(compose(frame, { x: 3, y: 0, theta: Math.PI }).theta, -Math.PI / 2);
  const moved = placeAll(frame, new Float32Array([3, 0, 0, 1]));
  [1, 5, 0, 2].forEach((value, i) => near(moved[i], value));
});

test("a line is as long as its pieces", () => {
  near(lengthOf(new Float32Array([0, 0, 3, 4, 3, 5])), 6);
  near(lengthOf(new Float32Array([])), 0);
});
