// An operator in plain roslib: looks around, drives the robot by topic and by action, and offers a service.
// node operator.mjs WS_URL '{"near": POSE, "far": POSE, "start": POSE}'; prints what it found as one line of JSON.
import { Action, ActionClient, Goal, Param, Ros, ROS2TFClient, Service, TFClient, Topic } from "roslib";
import { rawGrid, sameMap } from "./raw.mjs";

const [url, given] = process.argv.slice(2);
const { near, far, back } = JSON.parse(given);
const found = {};

function connect(more = "") {
  return new Promise((resolve, reject) => {
    const ros = new Ros();
    ros.on("connection", () => resolve(ros));
    ros.on("error", reject);
    ros.connect(url + more).catch(reject);
  });
}

function within(seconds, what, promise) {
  return new Promise((resolve, reject) => {
    const timer = setTimeout(() => reject(new Error(`${what}: nothing within ${seconds} s`)), seconds * 1000);
    promise.then(resolve, reject).finally(() => clearTimeout(timer));
  });
}

const asked = (what, ask) => within(20, what, new Promise((resolve, reject) => ask(resolve, reject)));
const stamped = (pose) => ({ header: { frame_id: "map" }, pose });

// A service that another client advertises is known once the cloud has handled its frame, which may be after our call.
async function offered(ros, name) {
  while (!(await asked("services", (ok, no) => ros.getServices(ok, no))).includes(name)) {
    await new Promise((resolve) => setTimeout(resolve, 20));
  }
}

function call(ros, name, serviceType, request) {
  const service = new Service({ ros, name, serviceType });
  return asked(name, (resolve, reject) => service.callService(request, resolve, reject));
}

function next(ros, name, messageType, options = {}) {
  const topic = new Topic({ ros, name, messageType, ...options });
  return asked(name, (resolve) => topic.subscribe((message) => { topic.unsubscribe(); resolve(message); }));
}

async function lookAround(ros) {
  found.topics = (await asked("topics", (ok, no) => ros.getTopics(ok, no))).topics;
  found.mapType = await asked("topic type", (ok, no) => ros.getTopicType("/map", ok, no));
  found.services = await asked("services", (ok, no) => ros.getServices(ok, no));
  found.actions = await asked("actions", (ok, no) => ros.getActionServers(ok, no));
  const speed = new Param({ ros, name: "/move_base/controller_frequency" });
  found.frequency = await asked("parameter", (ok, no) => speed.get(ok, no));
  const map = await next(ros, "/map", "nav_msgs/OccupancyGrid", { compression: "cbor" });
  found.cells = [map.info.width * map.info.height, map.data.length];
  const plain = await next(ros, "/map", "nav_msgs/OccupancyGrid");
  const png = await next(ros, "/map", "nav_msgs/OccupancyGrid", { compression: "png" });
  found.packed = [map.data.constructor.name, ...[map, png].map(({ data }) => String([...data]) === String(plain.data))];
  await readRaw(ros);
  found.ros2Stamp = Object.keys((await next(ros, "/amcl_pose", "geometry_msgs/msg/PoseWithCovarianceStamped")).header.stamp);
  found.ros1Stamp = Object.keys((await next(ros, "/amcl_pose", "geometry_msgs/PoseWithCovarianceStamped")).header.stamp);
}

async function driveByTopic(ros) {
  const result = next(ros, "/move_base/result", "move_base_msgs/MoveBaseActionResult");
  new Topic({ ros, name: "/move_base_simple/goal", messageType: "geometry_msgs/PoseStamped" }).publish(stamped(near));
  found.byTopic = (await within(60, "result", result)).status.status;
}

function send(action, goal) {
  const sent = { feedback: [] };
  sent.result = new Promise((resolve) => {
    const told = (kind) => (values) => resolve({ [kind]: values });
    sent.moving = new Promise((moving) => {
      const feedback = (values) => { sent.feedback.push(values); moving(values); };
      sent.id = action.sendGoal(goal, told("result"), feedback, told("failed"));
    });
  });
  return sent;
}

async function driveByAction(ros) {
  const moveBase = new Action({ ros, name: "/move_base", actionType: "move_base_msgs/action/MoveBase" });
  const there = send(moveBase, { target_pose: stamped(back) });
  found.byAction = await within(60, "action", there.result);
  found.actionFeedback = there.feedback.length;
  const navigate = new Action({ ros, name: "navigate_to_pose", actionType: "nav2_msgs/action/NavigateToPose" });
  const away = send(navigate, { pose: stamped(far), behavior_tree: "" });
  const feedback = await within(20, "feedback", away.moving);
  navigate.cancelGoal(away.id);
  found.cancelled = await within(20, "cancel", away.result);
  found.navigateFeedback = [Object.keys(feedback), Object.keys(feedback.current_pose.header.stamp)];
  const refused = send(moveBase, { target_pose: { header: { frame_id: "moon" }, pose: near } });
  found.refused = await within(20, "refusal", refused.result);
}

async function driveByActionOfRos1(ros) {
  const client = new ActionClient({ ros, serverName: "/move_base", actionName: "move_base_msgs/MoveBaseAction", timeout: 5000 });
  const goal = new Goal({ actionClient: client, goalMessage: { target_pose: stamped(far) } });
  const feedback = asked("feedback", (resolve) => goal.on("feedback", resolve));
  const result = asked("result", (resolve) => goal.on("result", () => resolve(goal.status.status)));
  goal.send();
  found.ros1Feedback = Object.keys(await feedback);
  goal.cancel();
  found.ros1Cancelled = await result;
  client.dispose();
}

async function serve(ros, other) {
  const args = { start: { header: {}, pose: near }, goal: stamped(far), tolerance: 0.2 };
  const plan = await call(ros, "/move_base/make_plan", "nav_msgs/GetPlan", args);
  found.poses = plan.plan.poses.length;
  const lights = new Service({ ros, name: "/lights", serviceType: "std_srvs/SetBool" });
  await lights.advertise((request, response) => { response.success = request.data; response.message = "on"; return true; });
  await offered(other, "/lights");
  found.lights = await call(other, "/lights", "std_srvs/SetBool", { data: true });
  const doors = new Service({ ros, name: "/doors", serviceType: "std_srvs/Trigger" });
  await doors.advertiseAsync(async () => { throw new Error("stuck"); });
  await offered(other, "/doors");
  found.doors = await call(other, "/doors", "std_srvs/Trigger", {}).catch((reason) => ({ reason }));
}

async function talk(ros, other) {
  const heard = next(other, "/chatter", "std_msgs/String");
  const chatter = new Topic({ ros, name: "/chatter", messageType: "std_msgs/String", latch: true });
  chatter.publish({ data: "hello" });
  found.chatter = [(await heard).data, (await next(other, "/chatter", "std_msgs/String")).data];
}

async function lookAtFrames(ros) {
  const options = { ros, fixedFrame: "map", angularThres: 0.01, transThres: 0.01, rate: 10 };
  const clients = [new ROS2TFClient(options), new TFClient(options)];
  const frames = clients.map((client) => asked("transform", (resolve) => client.subscribe("base_link", resolve)));
  found.frames = (await Promise.all(frames)).map((frame) => [frame.translation.x, frame.translation.y]);
  clients.forEach((client) => client.dispose());
}

async function readRaw(ros) {
  const plain = await next(ros, "/map", "nav_msgs/OccupancyGrid");
  found.raw = [];
  for (const [version, kind] of [[1, "nav_msgs/OccupancyGrid"], [2, "nav_msgs/msg/OccupancyGrid"]]) {
    found.raw.push(sameMap(rawGrid(await next(ros, "/map", kind, { compression: "cbor-raw" }), version), plain));
  }
}

try {
  const ros = await within(20, "connection", connect());
  const other = await within(20, "connection", connect());
  await lookAround(ros);
  await driveByTopic(ros);
  await driveByAction(ros);
  await driveByActionOfRos1(ros);
  await serve(ros, other);
  await talk(ros, other);
  await lookAtFrames(ros);
  console.log(JSON.stringify(found));
  process.exit(0);
} catch (error) {
  console.error(error, JSON.stringify(found));
  process.exit(1);
}
