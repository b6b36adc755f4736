// Robot of Arduino's client on a computer, which prints what it is told.
//
// arduino_scenes PORT MILLISECONDS
#include "posix_client.hpp"
#include "ppaas_robot.hpp"

static void drive(float vx, float vy, float wz) {
  printf("drive %.2f %.1f %.1f\n", double(vx), double(vy), double(wz));
}

static void text(const char *json, size_t size) { printf("text %.*s\n", int(size), json); }

int main(int, char **arguments) {
  PosixClient client;
  ppaas::Robot<PosixClient, 3, 300> robot(client, now, drive, text);
  robot.laser(-1.0f, 0.5f, 120, 8000, "base_scan");
  robot.begin("127.0.0.1", uint16_t(atoi(arguments[1])), "tb1", "t0ken");
  const unsigned long until = now() + strtoul(arguments[2], nullptr, 10);
  bool said = false;
  while (now() < until && robot.state() != ppaas::State::REFUSED) {
    if (robot.poll() && !said) {
      const uint16_t ranges[] = {1500, ppaas::NO_READING, ppaas::OUT_OF_REACH};
      memcpy(robot.ranges, ranges, sizeof ranges);
      robot.subscribe("amcl_pose", "geometry_msgs/PoseWithCovarianceStamped");
      robot.send_odom(1.0f, 2.0f, 0.5f, 0.25f, 0.0f, -0.5f, 7);
      said = robot.send_scan(8);
    }
    usleep(10000);
  }
  if (robot.state() == ppaas::State::REFUSED) printf("refused %s\n", robot.lost());
  robot.leave();
}
