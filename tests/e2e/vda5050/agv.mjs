// Virtual AGV of vda-5050-lib, which obeys a master control until it is killed.
// Argument: JSON with transport, agv, position ({x, y, theta, mapId}), speed [m/s].
import vda from "vda-5050-lib";

const { AgvController, VirtualAgvAdapter } = vda;
const { transport, agv, position, speed } = JSON.parse(process.argv[2]);
const controller = new AgvController(
  agv,
  { interfaceName: "uagv", transport, vdaVersion: "2.0.0" },
  { agvAdapterType: VirtualAgvAdapter, publishStateInterval: 1000, publishVisualizationInterval: 500 },
  { initialPosition: { ...position, lastNodeId: "" }, vehicleSpeed: speed },
);
await controller.start();
console.log("ready");
process.on("SIGTERM", async () => {
  await controller.stop();
  process.exit(0);
});
