// Hardware of the sketch of arduino_board.cpp, with which it is linked: a modem that is not there.
#include <stddef.h>
#include <stdint.h>

struct Client {
  int connect(const char *, uint16_t);
  size_t write(const uint8_t *, size_t);
  int available();
  int read(uint8_t *, size_t);
  uint8_t connected();
  void stop();
};

static volatile uint32_t registers[4];

int Client::connect(const char *, uint16_t) { return int(registers[0]); }
size_t Client::write(const uint8_t *, size_t) { return registers[1]; }
int Client::available() { return int(registers[2]); }
int Client::read(uint8_t *, size_t) { return int(registers[2]); }
uint8_t Client::connected() { return uint8_t(registers[0]); }
void Client::stop() { registers[0] = 0; }
Client client;
unsigned long millis() { return registers[3]; }
void drive(float, float, float) {}
void heard(const char *, size_t) {}

void setup();
void loop();

int main() {
  setup();
  while (registers[0]) loop();
}
