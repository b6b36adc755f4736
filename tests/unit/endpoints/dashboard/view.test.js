import assert from "node:assert/strict";
import test from "node:test";

import { View, rulerOf } from "../../../../endpoints/dashboard/static/js/view.js";

function view() {
  return Object.assign(new View(), { width: 800, height: 600, centre: { x: 3, y: -2 }, scale: 40 });
}

const near = (a, b) => assert.ok(Math.abs(a - b) < 1e-9, `${a} is not ${b}`);

test("the screen and the world agree, and y goes up", () => {
  const seen = view();
  const world = seen.toWorld(seen.toScreen({ x: 1.25, y: 7.5 }));
  near(world.x, 1.25);
  near(world.y, 7.5);
  assert.ok(seen.toScreen({ x: 0, y: 1 }).y < seen.toScreen({ x: 0, y: 0 }).y);
});

test("zooming keeps what is under the finger, also at the limits", () => {
  const seen = view();
  const at = { x: 123, y: 456 };
  const before = seen.toWorld(at);
  for (const factor of [3, 1e9, 1e-12]) {
    seen.zoom(at, factor);
    near(seen.toWorld(at).x, before.x);
    near(seen.toWorld(at).y, before.y);
  }
  assert.ok(seen.scale > 0);
});

test("panning moves the map with the finger", () => {
  const seen = view();
  const before = seen.toScreen({ x: 1, y: 1 });
  seen.pan(30, -20);
  near(seen.toScreen({ x: 1, y: 1 }).x, before.x + 30);
  near(seen.toScreen({ x: 1, y: 1 }).y, before.y - 20);
});

test("a box fits into what nothing covers", () => {
  const seen = view();
  seen.fit({ left: -5, right: 15, bottom: 0, top: 10 }, { top: 80, bottom: 20, side: 10 });
  for (const corner of [{ x: -5, y: 0 }, { x: 15, y: 10 }]) {
    const { x, y } = seen.toScreen(corner);
    assert.ok(x >= 9.99 && x <= 790.01 && y >= 79.99 && y <= 580.01, `${x} ${y}`);
  }
});

test("a ruler has a round length and its place", () => {
  for (const scale of [0.5, 7, 50, 333, 800]) {
    const { metres, pixels } = rulerOf(scale, 120);
    assert.ok(pixels <= 120 && pixels > 40, `${pixels}`);
    assert.match(metres.toExponential(), /^[125](e|\.0+[0-9]*e)/);
  }
});
