/** Machines, endpoints and containers with their load. */

import { byId, make, say, show } from "./dom.js";
import { bytes, number, plural } from "./format.js";

const HIGH = 0.9;

/** @typedef {{what: string, share: number, value: string, full?: boolean}} Gauge `full`: that it is full is bad */

/** @param {object} machine @returns {Gauge[]} */
export function machineGauges({ cores, load, memory, memory_used: used }) {
  return [
    { what: "CPU", share: load / cores, value: `${number(load)} of ${plural(cores, "core")}`, full: load > HIGH * cores },
    { what: "Memory", share: used / memory, value: `${bytes(used)} of ${bytes(memory)}`, full: used > HIGH * memory },
  ];
}

/** @param {object} endpoint it uses one core at most @param {object[]} machines @returns {Gauge[]} */
export function endpointGauges({ cpu, memory, machine }, machines) {
  const whole = (machines.find(({ id }) => id === machine) ?? machines[0])?.memory;
  return [
    { what: "CPU", share: cpu, value: `${number(cpu, 2)} of 1 core`, full: cpu > HIGH },
    { what: "Memory", share: whole ? memory / whole : 0, value: whole ? `${bytes(memory)} of ${bytes(whole)}` : bytes(memory) },
  ];
}

/** @param {object} endpoint @returns {string} */
export function endpointNote({ state, sockets, frames }) {
  const load = `${plural(sockets, "socket")} · ${number(frames, 0)} frames/s`;
  return state === "ready" ? load : `${state} · ${load}`;
}

/** @param {object} container @param {number} largest PSS of any container @returns {Gauge[]} */
export function containerGauges({ cores, cpu, pss }, largest) {
  return [
    { what: "CPU", share: cpu / cores, value: `${number(cpu, 2)} of ${plural(cores, "core")}`, full: cpu > HIGH * cores },
    { what: "PSS", share: pss / largest, value: bytes(pss) },
  ];
}

function create() {
  return make(
    "li", { className: "load" },
    make("div", { className: "head" }, make("span", { className: "name" }), make("span", { className: "note" })),
    make("div", { className: "gauges" }),
  );
}

/** @param {HTMLElement} item @param {string} name @param {string} note @param {Gauge[]} gauges */
function fill(item, name, note, gauges) {
  say(item.querySelector(".name"), name);
  say(item.querySelector(".note"), note);
  show(item.querySelector(".gauges"), gauges, ({ what }) => what, createGauge, fillGauge);
}

/** @param {Gauge} gauge */
function createGauge({ what }) {
  return make(
    "div", { className: "gauge" },
    make("span", { className: "what", textContent: what }),
    make("span", { className: "track", role: "meter", "aria-label": what, "aria-valuemin": 0, "aria-valuemax": 100 },
      make("span", { className: "fill" })),
    make("span", { className: "value" }),
  );
}

/** @param {HTMLElement} element @param {Gauge} gauge */
function fillGauge(element, { share, value, full }) {
  const percent = Math.round(100 * Math.min(1, Math.max(0, share || 0)));
  const track = element.children[1];
  track.firstChild.style.width = `${percent}%`;
  track.dataset.level = full ? "high" : "";
  track.setAttribute("aria-valuenow", String(percent));
  track.setAttribute("aria-valuetext", value);
  say(element.children[2], value);
}

/** Mark the loads as old while the cloud does not answer. @param {Date | null} since the time of the loads, null if they are new */
export function markLoads(since) {
  byId("panel-load").toggleAttribute("data-old", since !== null);
  byId("load-note").hidden = since === null;
  if (since) say(byId("load-note"), `As of ${since.toLocaleTimeString()}: the cloud does not answer`);
}

/** @param {object[] | null} machines null where the user may not see them */
export function showMachines(machines) {
  const none = byId("no-machines");
  none.hidden = Boolean(machines?.length);
  say(none, machines ? "No machine has registered." : "Administrators see the machines of the cloud here.");
  show(byId("machines"), machines ?? [], ({ id }) => id, create, (item, machine) => {
    const given = `${plural(machine.containers, "container")} · ${number(machine.capacity, 0)} cores to give`;
    fill(item, machine.id, machine.state === "ready" ? given : `${machine.state} · ${given}`, machineGauges(machine));
  });
}

/** @param {object[] | null} endpoints @param {object[] | null} machines both null where the user may not see them */
export function showEndpoints(endpoints, machines) {
  byId("endpoints-load").hidden = endpoints === null;
  show(byId("endpoints"), endpoints ?? [], ({ id }) => id, create, (item, endpoint) => {
    fill(item, endpoint.id, endpointNote(endpoint), endpointGauges(endpoint, machines ?? []));
  });
}

/** @param {object[]} containers @param {boolean} owners whether to say whose each is */
export function showContainers(containers, owners) {
  const largest = Math.max(1, ...containers.map(({ pss }) => pss ?? 0));
  const several = new Set(containers.map(({ machine }) => machine)).size > 1;
  byId("no-containers").hidden = containers.length > 0;
  say(byId("container-count"), containers.length ? String(containers.length) : "");
  show(byId("containers"), containers, ({ id }) => id, create, (item, container) => {
    const group = { coordinator: "people", traffic: "traffic" }[container.kind];
    const name = container.robot ?? `${group ?? "planning"} on ${container.map.id}`;
    const ready = group ? "coordinates" : plural(container.clients, "client");
    const state = container.state === "ready" ? ready : "starts";
    const note = several ? `${state} · ${container.machine}` : state;
    fill(item, owners ? `${container.user} / ${name}` : name, note, containerGauges(container, largest));
  });
}
