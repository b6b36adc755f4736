import assert from "node:assert/strict";
import test from "node:test";

import { boundsOf, cellsAPixel, coloursOf, pixelsOf } from "../../../../endpoints/dashboard/static/js/grid.js";

const palette = { free: [255, 255, 255], occupied: [0, 0, 0], unknown: [10, 20, 30] };
const info = { resolution: 0.5, width: 4, height: 2, origin: { x: 1, y: 1, theta: 0 } };

test("free, occupied, between and unknown are told apart", () => {
  const bytes = new Uint8Array(coloursOf(palette).buffer);
  assert.deepEqual([...bytes.slice(0, 4)], [255, 255, 255, 255]);
  assert.deepEqual([...bytes.slice(400, 404)], [0, 0, 0, 255]);
  assert.deepEqual([...bytes.slice(1020, 1024)], [10, 20, 30, 255]);
  assert.equal(bytes[200], 128);
});

test("pixels are the cells in their order, the lowest row first", () => {
  const cells = new Int8Array([0, 100, -1, 0, 0, 0, 0, 100]);
  const { width, height, data } = pixelsOf({ info, cells }, palette);
  assert.deepEqual([width, height], [4, 2]);
  assert.deepEqual([...data].filter((_, i) => i % 4 === 0), [255, 0, 10, 255, 255, 255, 255, 0]);
});

test("of cells that share a pixel the most occupied shows, so that no wall vanishes", () => {
  const cells = new Int8Array([0, 0, -1, -1, 0, 100, -1, 0]);
  const { width, height, data } = pixelsOf({ info, cells }, palette, 2);
  assert.deepEqual([width, height], [2, 1]);
  assert.deepEqual([data[0], data[4]], [0, 255]);
});

test("a map that is larger than a canvas may be shares pixels", () => {
  assert.equal(cellsAPixel({ width: 4096, height: 10 }), 1);
  assert.equal(cellsAPixel({ width: 10, height: 4097 }), 2);
});

test("the box of a grid holds it however it is turned", () => {
  assert.deepEqual(boundsOf(info), { left: 1, right: 3, bottom: 1, top: 2 });
  const turned = boundsOf({ ...info, origin: { x: 1, y: 1, theta: Math.PI / 2 } });
  const near = (a, b) => assert.ok(Math.abs(a - b) < 1e-9);
  near(turned.left, 0);
  near(turned.right, 1);
  near(turned.bottom, 1);
  near(turned.top, 3);
});
