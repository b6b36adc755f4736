// Arduino's client fed with what a hostile cloud sends, case by case.
//
// Reads cases: a length (uint32), the size of the pieces in which they come (uint16), and the bytes. Writes for each a
// letter: the state of the client in the end. A sanitizer ends the program at the first fault.
#include "ppaas_robot.hpp"

#include <sys/mman.h>
#include <unistd.h>

#include <new>
#include <vector>

static unsigned long clock_now = 0;
static unsigned heard = 0;

static unsigned long millis() { return clock_now; }
static void drive(float, float, float) { ++heard; }

// Every character of a message is looked at, so that a sanitizer sees which are not there.
static void text(const char *json, size_t size) {
  for (size_t at = 0; at < size; ++at) heard += json[at] == '"';
}

class FedClient {
 public:
  std::vector<uint8_t> data;
  size_t piece = 1;

  int connect(const char *, uint16_t) { return at_ = 0, connected_ = 1; }
  size_t write(const uint8_t *bytes, size_t size) {
    for (size_t at = 0; at < size; ++at) heard += bytes[at];
    return size > piece ? piece : size;
  }
  int available() const { return connected_ ? int(data.size() - at_) : 0; }
  int read(uint8_t *to, size_t size) {
    const size_t left = data.size() - at_, count = size < left ? size : left, part = count < piece ? count : piece;
    if (part) memcpy(to, data.data() + at_, part);
    at_ += part;
    return part ? int(part) : -1;
  }
  uint8_t connected() const { return connected_ && at_ < data.size(); }
  void stop() { connected_ = 0; }

 private:
  size_t at_ = 0;
  uint8_t connected_ = 0;
};

static bool read_all(void *to, size_t size) {
  for (char *at = static_cast<char *>(to); size;) {
    const ssize_t count = ::read(0, at, size);
    if (count <= 0) return false;
    at += count, size -= size_t(count);
  }
  return true;
}

template <uint16_t Inbox>
using RobotWith = ppaas::Robot<FedClient, 8, Inbox>;

// The largest inbox of those that a robot of this size may have: nothing lies behind it.
template <uint16_t Inbox = 300>
constexpr uint16_t whole() {
  if constexpr (sizeof(RobotWith<Inbox>) == sizeof(RobotWith<Inbox + 1>)) {
    return whole<Inbox + 1>();
  } else {
    return Inbox;
  }
}

using Robot = RobotWith<whole()>;

// Memory that ends at a page which may not be read: functions of the C library, which a sanitizer does not see, fail too.
static void *guarded() {
  const size_t page = size_t(getpagesize()), size = (sizeof(Robot) + page - 1) / page * page;
  char *all = static_cast<char *>(mmap(nullptr, size + page, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0));
  if (mprotect(all + size, page, PROT_NONE)) abort();
  return all + size - sizeof(Robot);
}

int main() {
  void *const memory = guarded();
  struct Head {
    uint32_t size;
    uint16_t piece;
  } __attribute__((packed)) head;
  while (read_all(&head, sizeof head)) {
    FedClient client;
    client.data.resize(head.size), client.piece = head.piece ? head.piece : 1;
    if (!read_all(client.data.data(), head.size)) return 1;
    Robot *const robot = new (memory) Robot(client, millis, drive, text);
    robot->begin("host", 8500, "tb1", "t0ken");
    for (size_t round = 0; round < head.size / 32 + 8; ++round) {
      robot->poll();
      robot->send_scan();
      clock_now += 300;
    }
    heard += unsigned(strlen(robot->lost()));
    const char state = char('A' + int(robot->state()));
    robot->~Robot();
    if (::write(1, &state, 1) != 1) return 1;
  }
  return 0;
}
