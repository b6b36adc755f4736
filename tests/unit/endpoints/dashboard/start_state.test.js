import assert from "node:assert/strict";
import test from "node:test";

import { startText } from "../../../../endpoints/dashboard/static/js/start_state.js";

const kernels = { done: 12, total: 107, compiling: ["lattice/driving"] };

test("nothing is said of a cloud that can start containers", () => {
  assert.deepEqual(["ok", "degraded"].map((status) => startText({ status, kernels })), ["", ""]);
});

test("a cloud that is starting says how far it is", () => {
  assert.equal(startText({ status: "starting", kernels: null }), "The cloud is starting…");
  const text = startText({ status: "starting", kernels });
  assert.match(text, /^The cloud is starting: compiling kernels, 12 of 107 \(now lattice\/driving\)\./);
  assert.doesNotMatch(startText({ status: "starting", kernels: { ...kernels, compiling: [] } }), /now/);
});
