// A robot below a namespace and its operator in plain roslib 2, by addresses alone: the robot offers an action, the
// operator sends goals to it, cancels one, and hears the heartbeat of the cloud.
// node docking.mjs WS_URL NAMESPACE; prints what it found as one line of JSON.
import { Action, Ros, Service, Topic } from "roslib";

const [url, namespace] = process.argv.slice(2);
const actionType = "dock_msgs/action/Dock";
setTimeout(() => { console.error("nothing more came"); process.exit(1); }, 60_000).unref();

async function open(address) {
  const ros = new Ros();
  await new Promise((resolve, reject) => {
    ros.on("connection", resolve);
    ros.on("error", reject);
    ros.connect(address).catch(reject);
  });
  return ros;
}

function call(ros, name, type, request = {}) {
  const service = new Service({ ros, name, serviceType: `rosapi_msgs/srv/${type}` });
  return new Promise((resolve, reject) => service.callService(request, resolve, reject));
}

const robot = await open(url);
const operator = await open(`${url}&role=operator`);
const dock = new Action({ ros: robot, name: `/${namespace}/dock`, actionType });
const goals = [];
dock.advertise(
  (goal, id) => {
    goals.push(goal);
    dock.sendFeedback(id, { state: 1 });
    if (goal.dock_id === "home") dock.setSucceeded(id, { success: true });
    if (goal.dock_id === "gone") dock.setFailed(id);
  },
  (id) => dock.setCanceled(id, { success: false }),
);
while (!(await call(operator, "/rosapi/action_servers", "GetActionServers")).action_servers.includes("/dock"));

const sending = new Action({ ros: operator, name: "/dock", actionType });
function send(dockId, cancel) {
  return new Promise((resolve) => {
    const heard = [];
    const feedback = (message) => { heard.push(message); if (cancel) sending.cancelGoal(id); };
    const id = sending.sendGoal(
      { dock_id: dockId },
      (result) => resolve({ result, heard }), feedback, (reason) => resolve({ failed: String(reason), heard }),
    );
  });
}
const ends = { home: await send("home"), away: await send("away", true), gone: await send("gone") };

const beats = await new Promise((resolve) => {
  const heard = [];
  const topic = new Topic({ ros: operator, name: "/ppaas/heartbeat", messageType: "std_msgs/msg/Header" });
  topic.subscribe((message) => { if (heard.push(message.stamp.sec) === 2) resolve(heard); });
});
console.log(JSON.stringify({
  goals,
  ends,
  beats,
  actionType: (await call(operator, "/rosapi/action_type", "ActionType", { action: "/dock" })).type,
  topicType: (await call(robot, "/rosapi/topic_type", "TopicType", { topic: `/${namespace}/cmd_vel` })).type,
  version: (await call(operator, "/rosapi/get_ros_version", "GetROSVersion")).version,
}));
process.exit(0);
