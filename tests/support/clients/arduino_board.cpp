// A sketch for a board; its Client and its clock are elsewhere.
#include "ppaas_robot.hpp"

struct Client {
  int connect(const char *, uint16_t);
  size_t write(const uint8_t *, size_t);
  int available();
  int read(uint8_t *, size_t);
  uint8_t connected();
  void stop();
};
unsigned long millis();
void drive(float, float, float);
void heard(const char *, size_t);
extern Client client;

ppaas::Robot<Client> robot(client, millis, drive, heard);
static_assert(sizeof robot <= 20 * 1024, "a board has 20 kB");

void setup() {
  robot.laser(0, 0.01745f, 120, 8000);
  robot.begin("host", 8500, "board", "token");
}

void loop() {
  robot.send_odom(0, 0, 0, 0, 0, 0);
  robot.send_scan();
  robot.poll();
}
