// Client of PPaaS for boards with Arduino's Client (WiFiClient, EthernetClient, TinyGsmClient ...), in C++17.
//
// Scans, odometry and velocities are compact frames, all else is JSON; see docs/microcontrollers.md for an example, and
// docs/protocol.md for the protocol. No exceptions, no heap: a robot of 360 beams takes about 2 kB. Only connect() and
// write() of the Client may block.
#pragma once

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#if defined(__BYTE_ORDER__) && __BYTE_ORDER__ != __ORDER_LITTLE_ENDIAN__
#error "compact frames are copied from memory, which must be little-endian"
#endif

namespace ppaas {

constexpr uint32_t STALE = 500;       // [ms] without cmd_vel after which the robot is stopped
constexpr uint32_t SILENT = 20000;    // [ms] without a byte of the cloud, which pings every 5 s
constexpr uint32_t PATIENCE = 5000;   // [ms] for the handshake
constexpr uint32_t LONGEST_WAIT = 8000;  // [ms] between two attempts to connect

constexpr uint16_t NO_READING = 0, OUT_OF_REACH = 65535;  // ranges without a distance

// Topics whose messages are always longer than the memory of a board.
constexpr const char *LARGE[] = {"map", "map_updates", "plan", "local_plan", "particlecloud", "key_frames", "cloud_in",
                                 "octomap_binary", "octomap_full", "projected_map", "robot_description"};

enum class State : uint8_t { AWAY, GREETING, REFUSING, OPEN, REFUSED };

// Beams: ranges of a scan; Inbox: longest message that is read [bytes].
template <class Client, uint16_t Beams = 360, uint16_t Inbox = 1024>
class Robot {
  static_assert(Inbox >= 256, "the inbox holds the lines of the handshake");

 public:
  using Clock = unsigned long (*)();                      // milliseconds, as millis()
  using Drive = void (*)(float vx, float vy, float wz);   // [m/s, m/s, rad/s]; zeros when the robot must stop
  using Text = void (*)(const char *json, size_t size);   // a message in JSON, without a zero at its end

  uint16_t ranges[Beams] = {};  // [mm]; NO_READING, OUT_OF_REACH

  Robot(Client &client, Clock clock, Drive drive, Text text = nullptr)
      : client_(client), clock_(clock), drive_(drive), text_(text) {}

  // The texts must outlive the robot. Call it once, and again after the state REFUSED.
  void begin(const char *host, uint16_t port, const char *robot, const char *token, const char *session = "board") {
    host_ = host, port_ = port, robot_ = robot, token_ = token, session_ = session;
    id_[0] = 0, wait_ = 0, state_ = State::AWAY;
    again_ = now();
  }

  // Angles [rad], distances [mm], frame of the laser (up to 40 characters, which must outlive the robot).
  void laser(float angle_min, float step, uint16_t nearest, uint16_t farthest, const char *frame = "") {
    frame_ = frame, name_ = 0;
    while (name_ < 40 && frame[name_]) ++name_;
    copy(scan_ + 16, angle_min), copy(scan_ + 20, step), copy(scan_ + 24, nearest), copy(scan_ + 26, farthest);
  }

  bool send_scan(unsigned long stamp = 0) {
    const uint16_t size = 20 + 2 * Beams + name_, count = Beams;
    uint8_t *begin = scan_ + (size < 126 ? 2 : 0);  // a short frame has a shorter head
    head(begin, 0x82, size);
    scan_[8] = 1, scan_[9] = name_;
    copy(scan_ + 10, count), copy(scan_ + 12, uint32_t(stamp));
    return send(begin, size_t(scan_ + 28 - begin)) && send(ranges, 2 * Beams) && (!name_ || send(frame_, name_));
  }

  // Pose in the frame of odometry [m, rad], velocity of the robot [m/s, rad/s], stamp of the clock of the scans [ms].
  bool send_odom(float x, float y, float yaw, float vx, float vy, float wz, unsigned long stamp = 0) {
    uint8_t frame[38] = {0x82, 0xA0, 0, 0, 0, 0, 2, 0, 6, 0};
    const float values[] = {x, y, yaw, vx, vy, wz};
    copy(frame + 10, uint32_t(stamp));
    memcpy(frame + 14, values, sizeof values);
    return send(frame, sizeof frame);
  }

  // Send an operation of rosbridge.
  bool say(const char *json) { return say(json, strlen(json)); }

  bool say(const char *json, size_t size) {
    uint8_t frame[8];
    return size < 65536 && send(frame, head(frame, 0x81, uint16_t(size))) && send(json, size);
  }

  // Subscribe to a topic, after each connection of which resumed() is false; return false if it is too large or not sent.
  bool subscribe(const char *topic, const char *type, uint16_t throttle_rate = 0) {
    char json[192];
    if (large(topic)) return false;
    const int size = snprintf(json, sizeof json,
                              "{\"op\":\"subscribe\",\"topic\":\"%s\",\"type\":\"%s\",\"throttle_rate\":%u}", topic, type,
                              unsigned(throttle_rate));
    return size > 0 && size < int(sizeof json) && say(json, size_t(size));
  }

  // Read what came, stop a robot that hears nothing, connect again: call it at least ten times a second. Returns whether
  // the robot is connected.
  bool poll() {
    if (state_ == State::AWAY && int32_t(now() - again_) >= 0) dial();
    for (int parts = 0; parts < 64 && alive() && client_.available() > 0; ++parts) receive();
    if (alive() && client_.available() <= 0) {
      const uint32_t quiet = now() - heard_;
      if (!client_.connected()) {
        state_ == State::REFUSING ? refuse() : close("the cloud closed the connection");
      } else if (state_ == State::OPEN ? quiet > SILENT : quiet > PATIENCE) {
        state_ == State::REFUSING ? refuse() : close("the cloud is silent");
      }
    }
    if (now() - driven_ > STALE) stop();
    return state_ == State::OPEN;
  }

  // The robot will not come back: the cloud need not keep its session.
  void leave() {
    uint8_t frame[14];
    const size_t begin = head(frame, 0x88, 6);
    memcpy(frame + begin, "\x03\xe8left", 6);
    send(frame, begin + 6);
    close("left");
    state_ = State::REFUSED;
  }

  State state() const { return state_; }
  bool resumed() const { return resumed_; }          // whether the cloud kept the session, with its subscriptions
  const char *lost() const { return lost_; }         // why the last connection ended
  uint32_t received() const { return received_; }    // messages of this session
  uint32_t passed() const { return passed_; }        // messages that were longer than the inbox

 private:
  uint32_t now() const { return uint32_t(clock_()); }
  bool alive() const { return state_ != State::AWAY && state_ != State::REFUSED; }

  template <class Number>
  static void copy(uint8_t *to, Number number) {
    memcpy(to, &number, sizeof number);
  }

  static bool large(const char *topic) {
    if (*topic == '/') ++topic;
    for (const char *one : LARGE)
      if (!strcmp(one, topic)) return true;
    const size_t size = strlen(topic);
    return size >= 7 && !strcmp(topic + size - 7, "costmap");
  }

  // -- to the cloud

  // Write the head of a frame, and return its size. The mask is zeros, so that nothing need be masked.
  static size_t head(uint8_t *frame, uint8_t first, uint16_t size) {
    const size_t begin = size < 126 ? 2 : 4;
    frame[0] = first, frame[1] = uint8_t(0x80 | (size < 126 ? size : 126));
    if (begin == 4) frame[2] = uint8_t(size >> 8), frame[3] = uint8_t(size);
    memset(frame + begin, 0, 4);
    return begin + 4;
  }

  bool send(const void *data, size_t size) { return state_ == State::OPEN && put(data, size); }

  bool put(const void *data, size_t size) {
    const uint8_t *at = static_cast<const uint8_t *>(data);
    while (size) {
      const size_t count = client_.write(at, size);
      if (!count || count > size) return close("the cloud does not read"), false;
      at += count, size -= count;
    }
    return true;
  }

  bool put(const char *text) { return put(text, strlen(text)); }

  void stop() {
    if (moving_) moving_ = false, drive_(0, 0, 0);
  }

  void close(const char *reason) {
    stop();
    if (!alive()) return;
    client_.stop();
    state_ = State::AWAY;
    snprintf(lost_, sizeof lost_, "%s", reason);
    again_ = now() + wait_;
    wait_ = 2 * wait_ + 250 < LONGEST_WAIT ? 2 * wait_ + 250 : LONGEST_WAIT;
  }

  // -- the handshake

  void dial() {
    char number[24];
    state_ = State::GREETING;  // so that close() is heard
    if (!client_.connect(host_, port_)) return close("no connection");
    status_ = 0, at_ = 0, got_ = 0, size_ = 0, heard_ = now(), resumed_ = false, new_id_[0] = 0;
    snprintf(number, sizeof number, ".%lu", static_cast<unsigned long>(received_));
    // The key is for caches, which a connection of a robot does not meet; it need not be random.
    const bool kept = id_[0] != 0;
    put("GET /?robot=") && put(robot_) && put("&status=1&compact=1&session=") && put(session_) && put("&resume=") &&
        put(kept ? id_ : "none") && put(kept ? number : "") && put(" HTTP/1.1\r\nHost: ") && put(host_) &&
        put("\r\nAuthorization: Bearer ") && put(token_) &&
        put("\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
            "Sec-WebSocket-Key: cHBhYXMtcm9ib3Qtc2tleQ==\r\n\r\n");
  }

  // Take a character of the head of the answer.
  void greet(char character) {
    if (character != '\n') {
      if (at_ < Inbox - 1) inbox_[at_++] = uint8_t(character);
      return;
    }
    while (at_ && inbox_[at_ - 1] == '\r') --at_;
    inbox_[at_] = 0;
    line(reinterpret_cast<char *>(inbox_), at_);
    at_ = 0;
  }

  void line(char *text, size_t size) {
    if (!status_) {
      const char *space = strchr(text, ' ');
      status_ = space ? atoi(space) : -1;
    } else if (size) {
      if (const char *value = value_of(text, "ppaas-session")) resumed_ = !strcmp(value, "resumed");
      if (const char *value = value_of(text, "ppaas-session-id")) snprintf(new_id_, sizeof new_id_, "%s", value);
      if (const char *value = value_of(text, "content-length")) size_ = uint32_t(atol(value));
    } else if (status_ == 101) {
      opened();
    } else {
      state_ = State::REFUSING, size_ = size_ < Inbox - 1u ? size_ : Inbox - 1u;
      if (!size_) refuse();
    }
  }

  // Return the value of a header, or null if it is another one; names have no case.
  static const char *value_of(const char *text, const char *name) {
    for (; *name; ++name, ++text)
      if ((*text | 0x20) != *name && *text != *name) return nullptr;
    if (*text++ != ':') return nullptr;
    while (*text == ' ') ++text;
    return text;
  }

  void opened() {
    state_ = State::OPEN;
    if (!resumed_) received_ = 0, strcpy(id_, new_id_);
    need_ = 2, at_ = 0;
    if (!resumed_) say("{\"op\":\"subscribe\",\"topic\":\"cmd_vel\",\"type\":\"geometry_msgs/Twist\"}");
  }

  // The handshake was refused: give the reason to the program, and give up if it will not be another one soon.
  void refuse() {
    const int status = status_;
    char reason[24];
    if (text_ && got_) text_(reinterpret_cast<char *>(inbox_), got_);
    snprintf(reason, sizeof reason, "HTTP status %d", status);
    close(reason);
    if (status == 400 || status == 401 || status == 403 || status == 404 || status == 422) state_ = State::REFUSED;
  }

  // -- from the cloud

  // Read a part of what came.
  void receive() {
    heard_ = now();
    if (state_ == State::GREETING) {
      uint8_t character;
      if (client_.read(&character, 1) == 1) greet(char(character));
    } else if (state_ == State::REFUSING) {
      got_ += read(inbox_ + got_, size_ - got_);
      if (got_ >= size_) refuse();
    } else if (at_ < need_) {
      at_ += uint16_t(read(head_ + at_, need_ - at_));
      if (at_ == 2) need_ = (head_[1] & 127) < 126 ? 2 : (head_[1] & 127) == 126 ? 4 : 10;
      if (at_ == need_) measured();
    } else {
      const uint32_t left = size_ - got_;
      got_ += read(keep() ? inbox_ + got_ : inbox_, left < Inbox ? left : Inbox);
      if (got_ == size_) taken();
    }
  }

  uint32_t read(uint8_t *to, uint32_t size) {
    const int count = client_.read(to, size);
    return count > 0 ? uint32_t(count) : 0;
  }

  bool keep() const { return size_ <= Inbox; }

  void measured() {
    size_ = head_[1] & 127, got_ = 0;
    if (need_ > 2) size_ = 0;
    for (uint16_t byte = need_ == 10 ? 6 : 2; byte < need_; ++byte) size_ = size_ << 8 | head_[byte];
    if (!size_) taken();
  }

  // Handle a complete frame.
  void taken() {
    const uint8_t opcode = head_[0] & 15;
    at_ = 0, need_ = 2;
    if (opcode < 3) ++received_, wait_ = 0, passed_ += !keep();
    if (opcode == 9 && size_ < 126) {
      uint8_t frame[8];
      send(frame, head(frame, 0x8A, uint16_t(size_))) && send(inbox_, size_);
    } else if (opcode == 8) {
      closed();
    } else if (opcode == 2 && size_ == 20 && inbox_[0] == 3) {
      float velocity[3];
      memcpy(velocity, inbox_ + 8, sizeof velocity);
      driven_ = now(), moving_ = true;
      drive_(velocity[0], velocity[1], velocity[2]);
    } else if (opcode == 1 && keep() && text_) {
      text_(reinterpret_cast<char *>(inbox_), size_);
    }
  }

  void closed() {
    const bool told = size_ > 1 && keep();  // of a frame that was passed over, the inbox has the last piece
    const unsigned code = told ? inbox_[0] << 8 | inbox_[1] : 1005;
    char text[sizeof lost_];
    const int size = told ? int(size_ - 2) : 0;
    const char *reason = reinterpret_cast<char *>(inbox_) + 2;
    uint8_t frame[8];
    send(frame, head(frame, 0x88, 0));
    snprintf(text, sizeof text, "%u %.*s", code, size, reason);
    const bool later = (size >= 11 && !memcmp(reason, "unavailable", 11)) || (size >= 4 && !memcmp(reason, "idle", 4));
    close(text);
    if (code == 1008 || code == 4409 || (code == 1011 && !later)) state_ = State::REFUSED;
  }

  Client &client_;
  Clock clock_;
  Drive drive_;
  Text text_;
  const char *host_ = "", *robot_ = "", *token_ = "", *session_ = "", *frame_ = "";
  uint32_t again_ = 0, wait_ = 0, heard_ = 0, driven_ = 0, received_ = 0, passed_ = 0, size_ = 0, got_ = 0;
  int status_ = 0;
  uint16_t port_ = 0, at_ = 0, need_ = 2;
  uint8_t name_ = 0;
  State state_ = State::REFUSED;  // until begin()
  bool moving_ = false, resumed_ = false;
  char id_[68] = "", new_id_[68] = "", lost_[96] = "not connected";
  uint8_t head_[10] = {}, scan_[28] = {}, inbox_[Inbox] = {};
};

}  // namespace ppaas
