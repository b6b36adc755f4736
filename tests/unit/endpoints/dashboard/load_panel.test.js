import assert from "node:assert/strict";
import test from "node:test";

globalThis.document = { getElementById: () => null };
const { endpointGauges, endpointNote } = await import("../../../../endpoints/dashboard/static/js/load_panel.js");

test("an endpoint is shown with its core and its share of the memory", () => {
  const [cpu, memory] = endpointGauges({ cpu: 0.25, memory: 90 * 2 ** 20 }, 180 * 2 ** 20);
  assert.deepEqual([cpu.share, cpu.full, memory.share], [0.25, false, 0.5]);
  assert.match(cpu.value, /^0\.25 of 1 core$/);
  assert.equal(endpointGauges({ cpu: 0.95, memory: 1 }, 1)[0].full, true);
});

test("a silent endpoint is told", () => {
  assert.equal(endpointNote({ state: "ready", sockets: 1, frames: 59.6 }), "1 socket · 60 frames/s");
  assert.equal(endpointNote({ state: "silent", sockets: 3, frames: 0 }), "silent · 3 sockets · 0 frames/s");
});
