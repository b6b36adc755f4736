// Master control of vda-5050-lib: sends an AGV an order and its update, cancels another, and prints what it hears.
// Argument: JSON with transport, agv, mapId, nodes ({x, y}), away ({x, y}).
import vda from "vda-5050-lib";

const { MasterController, Topic } = vda;
const { transport, agv, mapId, nodes, away } = JSON.parse(process.argv[2]);
const master = new MasterController({ interfaceName: "uagv", transport, vdaVersion: "2.0.0" });
const told = { connection: [], factsheet: null, traversed: [], actions: [], instant: [], states: 0, rejected: [] };

const node = (index, place, released, actions = []) => ({
  nodeId: `n${index}`, sequenceId: 2 * index, released, actions,
  nodePosition: { x: place.x, y: place.y, mapId },
});
const edge = (index, released) => ({
  edgeId: `e${index}`, sequenceId: 2 * index + 1, released, actions: [],
  startNodeId: `n${index}`, endNodeId: `n${index + 1}`,
});
const action = (actionType, actionId, blockingType, actionParameters = []) =>
  ({ actionType, actionId, blockingType, actionParameters });

function processed(order, begun) {
  return new Promise((resolve, reject) => {
    begun?.(resolve);
    master.assignOrder(agv, order, {
      onOrderProcessed: (error, cancelled, active) => {
        if (error) told.rejected.push(error.errorType);
        resolve({ error: error?.errorType ?? null, cancelled, active });
      },
      onNodeTraversed: (one) => told.traversed.push(one.nodeId),
      onActionStateChanged: (state) => told.actions.push([state.actionId, state.actionStatus, state.resultDescription]),
    }).catch(reject);
  });
}

function ended(one) {
  return new Promise((resolve, reject) => {
    master.initiateInstantActions(agv, { instantActions: [one] }, {
      onActionStateChanged: (state, error) => {
        if (state.actionStatus === "FINISHED" || state.actionStatus === "FAILED") {
          resolve([one.actionType, state.actionStatus, error?.errorType ?? null]);
        }
      },
      onActionError: (error) => resolve([one.actionType, "ERROR", error.errorType]),
    }).catch(reject);
  });
}

master.on?.("error", (error) => console.error(error));
await master.start();
await master.subscribe(Topic.Connection, agv, (one) => told.connection.push(one.connectionState));
const localized = new Promise((resolve) => {
  master.subscribe(Topic.State, agv, (state) => {
    told.states += 1;
    if (state.agvPosition?.positionInitialized) resolve(state.agvPosition);
  });
});
await master.subscribe("factsheet", agv, (sheet) => { told.factsheet = sheet; }).catch(() => {});
told.position = await localized;

const [first, second, third] = nodes;
const orderId = master.createUuid();
const base = { orderId, orderUpdateId: 0, nodes: [node(0, first, true), node(1, second, true), node(2, third, false)],
  edges: [edge(0, true), edge(1, false)] };
told.base = await new Promise((resolve, reject) => {
  master.assignOrder(agv, base, {
    onOrderProcessed: (error, cancelled, active) => resolve({ error: error?.errorType ?? null, cancelled, active }),
    onNodeTraversed: (one) => { told.traversed.push(one.nodeId); if (one.nodeId === "n1") resolve("traversed"); },
  }).catch(reject);
});
const beep = action("beep", "a1", "HARD");
told.order = await processed({ orderId, orderUpdateId: 1, nodes: [node(1, second, true), node(2, third, true, [beep])],
  edges: [edge(1, true)] });

told.refused = await processed({ orderId: master.createUuid(), orderUpdateId: 0,
  nodes: [node(0, away, true), node(1, first, true)], edges: [edge(0, true)] });

told.instant.push(await ended(action("stateRequest", "i1", "NONE")));
told.instant.push(await ended(action("explode", "i2", "NONE")));

const back = { orderId: master.createUuid(), orderUpdateId: 0, nodes: [node(0, third, true), node(1, first, true)],
  edges: [edge(0, true)] };
const driving = processed(back);
await new Promise((resolve) => setTimeout(resolve, 1500));
told.instant.push(await ended(action("cancelOrder", "i3", "NONE")));
told.cancelled = await driving;

await master.stop();
console.log(JSON.stringify(told));
process.exit(0);
