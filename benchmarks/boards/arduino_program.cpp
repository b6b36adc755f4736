// Arduino's client on a computer, whose modem is memory: how long its work takes.
//
// arduino_program ROUNDS
//
// Prints the size of a robot [bytes], and the time of a scan, of an odometry, of a velocity, and of a scan as text by
// snprintf, without the client [ns].
#include <chrono>

#include "ppaas_robot.hpp"

static unsigned long clock_now = 0;
static unsigned long millis() { return clock_now; }
static float driven = 0;
static void drive(float vx, float, float wz) { driven += vx + wz; }

static const char GREETING[] = "HTTP/1.1 101 OK\r\nPPaaS-Session: new\r\nPPaaS-Session-Id: a\r\n\r\n";

// What the cloud sends comes from memory, and what the robot sends goes there.
class Modem {
 public:
  const uint8_t *given = nullptr;
  size_t left = 0;

  int connect(const char *, uint16_t) {
    given = reinterpret_cast<const uint8_t *>(GREETING), left = sizeof GREETING - 1;
    return 1;
  }
  size_t write(const uint8_t *data, size_t size) {
    memcpy(sent_, data, size < sizeof sent_ ? size : sizeof sent_);
    return size;
  }
  int available() const { return int(left); }
  int read(uint8_t *to, size_t size) {
    const size_t count = size < left ? size : left;
    memcpy(to, given, count);
    given += count, left -= count;
    return int(count);
  }
  uint8_t connected() const { return 1; }
  void stop() {}

 private:
  uint8_t sent_[4096];
};

template <class Work>
static double nanoseconds(long rounds, Work work) {
  const auto begin = std::chrono::steady_clock::now();
  for (long round = 0; round < rounds; ++round) work();
  return std::chrono::duration<double, std::nano>(std::chrono::steady_clock::now() - begin).count() / double(rounds);
}

int main(int, char **arguments) {
  const long rounds = atol(arguments[1]);
  static Modem modem;
  static ppaas::Robot<Modem> robot(modem, millis, drive);
  robot.laser(-3.14159265f, 0.01745329f, 120, 8000);
  robot.begin("host", 8500, "board", "token");
  for (int turn = 0; turn < 10 && !robot.poll(); ++turn) ++clock_now;
  if (robot.state() != ppaas::State::OPEN) return 1;
  uint8_t velocity[22] = {0x82, 20, 3, 0, 3, 0};
  const float speed = 0.25f;
  memcpy(velocity + 10, &speed, sizeof speed);
  const double scan = nanoseconds(rounds, [] { robot.send_scan(); });
  const double odometry = nanoseconds(rounds, [] { robot.send_odom(1, 2, 3, 4, 5, 6); });
  const double read = nanoseconds(rounds, [&] {
    modem.given = velocity, modem.left = sizeof velocity;
    robot.poll();
  });
  static char text[8192];
  const double as_text = nanoseconds(rounds / 100 + 1, [] {
    size_t at = 0;
    for (const uint16_t range : robot.ranges)
      at += size_t(snprintf(text + at, sizeof text - at, "%.3f,", double(range) / 1000));
  });
  if (driven < speed) return 1;
  printf("{\"size\":%zu,\"scan\":%f,\"odometry\":%f,\"velocity\":%f,\"text\":%f}\n", sizeof robot, scan, odometry, read,
         as_text);
}
