import assert from "node:assert/strict";
import test from "node:test";

globalThis.document = { getElementById: () => null };
const { endpointGauges, endpointNote } = await import("../../../../endpoints/dashboard/static/js/load_panel.js");

test("an endpoint is shown with its core and its share of the memory of its machine", () => {
  const machines = [{ id: "a", memory: 900 * 2 ** 20 }, { id: "b", memory: 180 * 2 ** 20 }];
  const [cpu, memory] = endpointGauges({ cpu: 0.25, memory: 90 * 2 ** 20, machine: "b" }, machines);
  assert.deepEqual([cpu.share, cpu.full, memory.share], [0.25, false, 0.5]);
  assert.match(cpu.value, /^0\.25 of 1 core$/);
  assert.equal(endpointGauges({ cpu: 0.95, memory: 1, machine: "b" }, machines)[0].full, true);
});

test("an endpoint of a machine that is not listed is shown with its memory alone", () => {
  const [, memory] = endpointGauges({ cpu: 0.25, memory: 90 * 2 ** 20, machine: "b" }, []);
  assert.deepEqual([memory.share, memory.value], [0, "90.0 MiB"]);
});

test("a silent endpoint is told", () => {
  assert.equal(endpointNote({ state: "ready", sockets: 1, frames: 59.6 }), "1 socket · 60 frames/s");
  assert.equal(endpointNote({ state: "silent", sockets: 3, frames: 0 }), "silent · 3 sockets · 0 frames/s");
});
