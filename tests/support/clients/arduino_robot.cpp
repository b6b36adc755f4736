// Robot of Arduino's client on a computer, whose body is simulated on the other side of its standard streams.
//
// arduino_robot HOST PORT ROBOT TOKEN
//
// Reads and writes the same records as micropython_robot.py.
#include "posix_client.hpp"
#include "ppaas_robot.hpp"

using Board = ppaas::Robot<PosixClient>;
static_assert(sizeof(Board) <= 20 * 1024, "a board has 20 kB");

static int poses = 0, scans = 0, reconnects = -1, resumed = 0;
static char errors[512];

static void write_all(const void *data, size_t size) {
  for (const char *at = static_cast<const char *>(data); size;) {
    const ssize_t count = ::write(1, at, size);
    if (count <= 0) exit(1);
    at += count, size -= size_t(count);
  }
}

static bool read_all(void *to, size_t size) {
  for (char *at = static_cast<char *>(to); size;) {
    const ssize_t count = ::read(0, at, size);
    if (count <= 0) return false;
    at += count, size -= size_t(count);
  }
  return true;
}

static void drive(float vx, float vy, float wz) {
  const float values[] = {vx, vy, wz};
  write_all("v", 1);
  write_all(values, sizeof values);
}

static void text(const char *json, size_t size) {
  if (memmem(json, size, "\"amcl_pose\"", 11)) ++poses;
  if (memmem(json, size, "\"status\"", 8) && !errors[0]) snprintf(errors, sizeof errors, "%.*s", int(size), json);
}

int main(int, char **arguments) {
  PosixClient client;
  Board robot(client, now, drive, text);
  const bool refused = !robot.subscribe("/map", "nav_msgs/OccupancyGrid");
  robot.laser(-3.14159265f, 0.01745329f, 120, 8000);
  robot.begin(arguments[1], uint16_t(atoi(arguments[2])), arguments[3], arguments[4]);
  bool connected = false;
  for (char letter; read_all(&letter, 1);) {
    if (letter == 'o') {
      float o[6];
      if (!read_all(o, sizeof o)) break;
      robot.send_odom(o[0], o[1], o[2], o[3], o[4], o[5]);
    } else if (letter == 's') {
      if (!read_all(robot.ranges, sizeof robot.ranges)) break;
      robot.send_scan();
      ++scans;
    } else {
      char report[1024];
      const uint16_t size = uint16_t(snprintf(
          report, sizeof report,
          "{\"scans\":%d,\"reconnects\":%d,\"resumed\":%d,\"poses\":%d,\"bytes\":0,\"pause\":0,\"passed\":%u,\"lost\":\"%s\","
          "\"errors\":[%s%s%s]}",
          scans, reconnects, resumed, poses, unsigned(robot.passed()), robot.lost(),
          refused ? "\"map is too large for this board\"" : "", errors[0] ? "," : "", errors));
      write_all("r", 1);
      write_all(&size, 2);
      write_all(report, size);
    }
    if (robot.poll() && !connected) {
      ++reconnects, resumed += robot.resumed();
      if (!robot.resumed()) {
        robot.say("{\"op\":\"subscribe\",\"topic\":\"map\"}");
        robot.subscribe("amcl_pose", "geometry_msgs/PoseWithCovarianceStamped", 1000);
      }
    }
    connected = robot.state() == ppaas::State::OPEN;
  }
}
