// Reads messages of the compression cbor-raw by Foxglove's libraries, which are independent of ours.
import { ros1, ros2jazzy } from "@foxglove/rosmsg-msgs-common";
import { MessageReader as Reader1 } from "@foxglove/rosmsg-serialization";
import { MessageReader as Reader2 } from "@foxglove/rosmsg2-serialization";

// Returns the readers' definitions of a message: it first, then those in it.
function definitions(all, name) {
  const found = new Map();
  (function add(type) {
    if (found.has(type)) return;
    found.set(type, all[type]);
    for (const field of all[type].definitions) if (field.isComplex) add(field.type);
  })(name);
  return [...found.values()];
}

const READERS = {
  1: new Reader1(definitions(ros1, "nav_msgs/OccupancyGrid")),
  2: new Reader2(definitions(ros2jazzy, "nav_msgs/OccupancyGrid")),
};

export function rawGrid({ secs, nsecs, bytes }, ros) {
  if (Math.abs(Date.now() / 1000 - secs) > 60 || nsecs >= 1e9) throw new Error(`sent at ${secs}.${nsecs}`);
  const view = new Uint8Array(bytes); // copied: cbor-js returns a part of the frame
  return READERS[ros].readMessage(view);
}

export function sameMap(grid, plain) {
  const { width, height, resolution, origin } = grid.info;
  const close = Math.abs(resolution - plain.info.resolution) < 1e-6;
  return close && width === plain.info.width && height === plain.info.height
    && origin.position.x === plain.info.origin.position.x && String([...grid.data]) === String(plain.data)
    && grid.header.frame_id === "map";
}
