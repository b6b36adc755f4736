import assert from "node:assert/strict";
import { test } from "node:test";

globalThis.document = { createElement: () => ({ append() {}, setAttribute() {}, addEventListener() {} }) };
const { camerasOf, fitted, mediaOf, sizeOf } = await import("../../../../endpoints/dashboard/static/js/camera.js");

test("pictures of depth are no pictures that a browser shows", () => {
  assert.deepEqual(camerasOf(["/b/compressed", "depth/image_raw/compressedDepth", "a/compressed"]), ["a/compressed", "b/compressed"]);
});

test("the type of a picture is read from the formats of ROS 1 and ROS 2", () => {
  assert.deepEqual(["jpeg", "jpg", "PNG", "bgr8; jpeg compressed bgr8", "webp"].map(mediaOf), ["image/jpeg", "image/jpeg", "image/png", "image/jpeg", "image/webp"]);
  assert.deepEqual(["", undefined, "16UC1; compressedDepth", "tiff"].map(mediaOf), [null, null, null, null]);
});

test("the size of a picture is known before it is decoded", () => {
  assert.equal(sizeOf(Buffer.alloc(300).toString("base64")), 300);
});

test("wide pictures are drawn small, and small ones as they are", () => {
  assert.deepEqual(fitted({ width: 1920, height: 1080 }), { width: 640, height: 360 });
  assert.deepEqual(fitted({ width: 320, height: 240 }), { width: 320, height: 240 });
  assert.deepEqual(fitted({ width: 10_000, height: 1 }), { width: 640, height: 1 });
});
