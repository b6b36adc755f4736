// A viewer with the unmodified client of Foxglove's protocol: it looks at a robot, and drives it to a goal.
// Arguments: URL, robot, frame of the map, goal as JSON of geometry_msgs/Pose. Prints what it saw as JSON.

import { parse } from "@foxglove/rosmsg";
import { MessageReader } from "@foxglove/rosmsg2-serialization";
import wsProtocol from "@foxglove/ws-protocol";
import { WebSocket } from "ws";

const { FoxgloveClient } = wsProtocol;
const [url, robot, mapFrame, goalText] = process.argv.slice(2);
const SEEN = ["map", "scan", "tf", "tf_static", "plan", "amcl_pose", "model", "move_base/result"];
const TIMEOUT = 90_000;

const found = { counts: {}, schemas: {}, statuses: [], times: 0 };
const client = new FoxgloveClient({ ws: new WebSocket(url, [FoxgloveClient.SUPPORTED_SUBPROTOCOL]) });
const channels = new Map();
const subscriptions = new Map();
const services = new Map();
const waiting = [];
const failed = (error) => { console.error(String(error?.stack ?? error)); process.exit(1); };
setTimeout(() => failed(`timeout: ${JSON.stringify(found)}`), TIMEOUT).unref();

// Resolves once a condition on what was received holds.
const until = (condition) => new Promise((resolve) => {
  const check = () => { if (condition()) { resolve(); return true; } return false; };
  if (!check()) { waiting.push(check); }
});
const received = () => { for (const check of [...waiting]) { if (check()) { waiting.splice(waiting.indexOf(check), 1); } } };
const topicOf = (name) => `/${robot}/${name}`;
const once = (event, matches) => new Promise((resolve) => client.on(event, (value) => { if (matches(value)) { resolve(value); } }));

client.on("error", failed);
client.on("serverInfo", (info) => { found.serverInfo = info; received(); });
client.on("status", (status) => { found.statuses.push(status.message); received(); });
client.on("time", () => { found.times += 1; });
client.on("advertise", (news) => { for (const channel of news) { channels.set(channel.topic, channel); } received(); });
client.on("advertiseServices", (news) => { for (const service of news) { services.set(service.name, service); } received(); });
client.on("message", ({ subscriptionId, timestamp, data }) => {
  const name = subscriptions.get(subscriptionId);
  found.counts[name] = (found.counts[name] ?? 0) + 1;
  found.lag = Number(BigInt(Date.now()) - timestamp / 1_000_000n);
  if (["map", "amcl_pose", "move_base/result"].includes(name)) {
    const reader = new MessageReader(parse(channels.get(topicOf(name)).schema, { ros2: true }));
    const message = reader.readMessage(data);
    if (name === "map") {
      found.map = { width: message.info.width, cells: message.data.length, frame: message.header.frame_id };
    } else if (name === "amcl_pose") {
      found.amcl_pose = { ...message.pose.pose.position, frame: message.header.frame_id };
    } else {
      found.result = message.status.status;
    }
  }
  received();
});

await until(() => SEEN.every((name) => channels.has(topicOf(name))));
for (const name of SEEN) {
  const channel = channels.get(topicOf(name));
  found.schemas[name] = [channel.encoding, channel.schemaName, channel.schemaEncoding];
  subscriptions.set(client.subscribe(channel.id), name);
}
await until(() => ["map", "scan", "tf", "model"].every((name) => found.counts[name] > 0));

const publication = client.advertise({
  topic: topicOf("move_base_simple/goal"), encoding: "json", schemaName: "geometry_msgs/PoseStamped",
});
const goal = { header: { stamp: { sec: 0, nsec: 0 }, frame_id: mapFrame }, pose: JSON.parse(goalText) };
client.sendMessage(publication, new TextEncoder().encode(JSON.stringify(goal)));
await until(() => found.result !== undefined && found.counts.plan > 0);

const parameterName = topicOf("viewer/limit");
const values = once("parameterValues", (answer) => answer.id === "set");
client.setParameters([{ name: parameterName, value: 2, type: "float64" }], "set");
found.set = (await values).parameters;
const all = once("parameterValues", (answer) => answer.id === "all");
client.getParameters([], "all");
found.frequency = (await all).parameters.find(({ name }) => name === topicOf("move_base/controller_frequency"));

await until(() => services.has(topicOf("rosapi/get_param")));
const call = once("serviceCallResponse", ({ callId }) => callId === 7);
client.sendServiceCallRequest({
  serviceId: services.get(topicOf("rosapi/get_param")).id, callId: 7, encoding: "json",
  data: new TextEncoder().encode(JSON.stringify({ name: "/viewer/limit" })),
});
found.called = JSON.parse(new TextDecoder().decode((await call).data));
const graph = once("connectionGraphUpdate", () => true);
client.subscribeConnectionGraph();
found.publishers = (await graph).publishedTopics.find(({ name }) => name === topicOf("amcl_pose"));
console.log(JSON.stringify(found));
client.close();
