import assert from "node:assert/strict";
import test from "node:test";

import { bytes, degrees, duration, number, plural } from "../../../../endpoints/dashboard/static/js/format.js";

test("bytes have the unit that suits them", () => {
  assert.deepEqual([0, 1023, 1024, 27_262_976, 25e9].map(bytes), ["0 B", "1023 B", "1.0 KiB", "26.0 MiB", "23.3 GiB"]);
  assert.equal(bytes(null), "–");
});

test("numbers that are none, or minus zero, are not shown as such", () => {
  assert.deepEqual([number(1.26), number(-0.01), number(-0.01, 2), number(null), number(NaN)], ["1.3", "0.0", "-0.01", "–", "–"]);
  assert.equal(degrees(-Math.PI / 2), "-90°");
});

test("one is not many", () => {
  assert.deepEqual([plural(1, "core"), plural(0.5, "core")], ["1 core", "0.5 cores"]);
});

test("a time is told in its largest unit", () => {
  assert.deepEqual([0, 59.9, 60, 3599, 7200].map(duration), ["0 s", "59 s", "1 min", "59 min", "2 h"]);
});
