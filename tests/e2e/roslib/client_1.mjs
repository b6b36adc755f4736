// A client in plain roslib 1: looks around, cancels a goal of Move Base's action, and reaches another one.
// node client_1.mjs WS_URL '{"near": POSE, "far": POSE}'; prints what it found as one line of JSON.
import { readFileSync } from "node:fs";
import ROSLIB from "roslib-1";
import { rawGrid, sameMap } from "./raw.mjs";

const [url, given] = process.argv.slice(2);
const poses = JSON.parse(given);
const ends = { 2: "cancelled", 3: "succeeded" };
setTimeout(() => { console.error("nothing more came"); process.exit(1); }, 120_000).unref();

const ros = new ROSLIB.Ros({ url, encoding: "utf8" });
await new Promise((resolve, reject) => { ros.on("connection", resolve); ros.on("error", reject); });

function next(name, messageType, compression = "none") {
  const topic = new ROSLIB.Topic({ ros, name, messageType, compression });
  return new Promise((resolve) => topic.subscribe(resolve));
}

function goalAt(name) {
  const target = { header: { frame_id: "map" }, pose: poses[name] };
  const goal = new ROSLIB.Goal({ actionClient: client, goalMessage: { target_pose: target } });
  const end = new Promise((resolve) => goal.on("result", () => resolve(ends[goal.status.status] ?? goal.status)));
  return { goal, end, feedback: new Promise((resolve) => goal.on("feedback", resolve)) };
}

const grid = await next("/map", "nav_msgs/OccupancyGrid");
const raw = await next("map", "nav_msgs/OccupancyGrid", "cbor-raw"); // a spelling that has a compression of its own
const { position } = (await next("/amcl_pose", "geometry_msgs/PoseWithCovarianceStamped")).pose.pose;
const plan = next("/plan", "nav_msgs/Path");
const client = new ROSLIB.ActionClient({ ros, serverName: "/move_base", actionName: "move_base_msgs/MoveBaseAction" });
const away = goalAt("far");
away.goal.send();
const moving = await away.feedback;
away.goal.cancel();
const first = await away.end;
const there = goalAt("near");
there.goal.send();
const second = await there.end;
const topics = await new Promise((resolve, reject) => ros.getTopics(resolve, reject));
const services = await new Promise((resolve, reject) => ros.getServices(resolve, reject));
client.dispose();
console.log(JSON.stringify({
  version: JSON.parse(readFileSync(new URL("node_modules/roslib-1/package.json", import.meta.url))).version,
  topics: topics.topics,
  services,
  cells: [grid.info.width * grid.info.height, grid.data.length],
  raw: sameMap(rawGrid(raw, 1), grid),
  pose: [position.x, position.y],
  plan: (await plan).poses.length,
  feedback: Object.keys(moving),
  ends: [first, second],
}));
process.exit(0);
