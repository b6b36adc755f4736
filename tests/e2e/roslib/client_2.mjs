// A client in plain roslib 2: looks around, cancels a goal of Nav2's action, and reaches another one.
// node client_2.mjs WS_URL '{"near": POSE, "far": POSE}'; prints what it found as one line of JSON.
import { readFileSync } from "node:fs";
import { Action, Ros, Topic } from "roslib";

const [url, given] = process.argv.slice(2);
const poses = JSON.parse(given);
setTimeout(() => { console.error("nothing more came"); process.exit(1); }, 120_000).unref();

const ros = new Ros();
await new Promise((resolve, reject) => {
  ros.on("connection", resolve);
  ros.on("error", reject);
  ros.connect(url).catch(reject);
});

function next(name, messageType) {
  const topic = new Topic({ ros, name, messageType });
  return new Promise((resolve) => topic.subscribe(resolve));
}

// roslib reports a cancelled goal as a failure, with this text.
const failed = (reason) => (String(reason).startsWith("GoalError: Action was canceled") ? "cancelled" : String(reason));

function send(name) {
  const sent = {};
  sent.feedback = new Promise((moving) => {
    sent.end = new Promise((resolve) => {
      const goal = { pose: { header: { frame_id: "map" }, pose: poses[name] }, behavior_tree: "" };
      sent.id = navigate.sendGoal(goal, () => resolve("succeeded"), moving, (reason) => resolve(failed(reason)));
    });
  });
  return sent;
}

const grid = await next("/map", "nav_msgs/msg/OccupancyGrid");
const { position } = (await next("/amcl_pose", "geometry_msgs/msg/PoseWithCovarianceStamped")).pose.pose;
const plan = next("/plan", "nav_msgs/msg/Path");
const navigate = new Action({ ros, name: "/navigate_to_pose", actionType: "nav2_msgs/action/NavigateToPose" });
const away = send("far");
const moving = await away.feedback;
navigate.cancelGoal(away.id);
const first = await away.end;
const second = await send("near").end;
const topics = await new Promise((resolve, reject) => ros.getTopics(resolve, reject));
const services = await new Promise((resolve, reject) => ros.getServices(resolve, reject));
console.log(JSON.stringify({
  version: JSON.parse(readFileSync(new URL("node_modules/roslib/package.json", import.meta.url))).version,
  topics: topics.topics,
  services,
  cells: [grid.info.width * grid.info.height, grid.data.length],
  pose: [position.x, position.y],
  plan: (await plan).poses.length,
  feedback: Object.keys(moving),
  ends: [first, second],
}));
process.exit(0);
