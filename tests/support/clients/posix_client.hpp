// Arduino's Client and its clock on a computer.
#pragma once

#include <netdb.h>
#include <poll.h>
#include <stdint.h>
#include <stdio.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

// Arduino's Client over POSIX sockets.
class PosixClient {
 public:
  int connect(const char *host, uint16_t port) {
    char service[8];
    addrinfo hints{}, *found = nullptr;
    hints.ai_socktype = SOCK_STREAM;
    snprintf(service, sizeof service, "%u", unsigned(port));
    if (getaddrinfo(host, service, &hints, &found)) return 0;
    socket_ = ::socket(found->ai_family, found->ai_socktype, 0);
    closed_ = ::connect(socket_, found->ai_addr, found->ai_addrlen) != 0;
    freeaddrinfo(found);
    return !closed_;
  }
  size_t write(const uint8_t *data, size_t size) {
    const ssize_t count = ::send(socket_, data, size, MSG_NOSIGNAL);
    return count > 0 ? size_t(count) : 0;
  }
  int available() {
    pollfd one{socket_, POLLIN, 0};
    int count = 0;
    if (socket_ < 0 || ::poll(&one, 1, 0) <= 0) return 0;
    ioctl(socket_, FIONREAD, &count);
    closed_ = closed_ || !count;
    return count;
  }
  int read(uint8_t *to, size_t size) { return int(::recv(socket_, to, size, MSG_DONTWAIT)); }
  uint8_t connected() { return socket_ >= 0 && !closed_; }
  void stop() {
    if (socket_ >= 0) ::close(socket_);
    socket_ = -1;
  }

 private:
  int socket_ = -1;
  bool closed_ = false;
};

// Milliseconds, as millis().
inline unsigned long now() {
  timespec time;
  clock_gettime(CLOCK_MONOTONIC, &time);
  return static_cast<unsigned long>(time.tv_sec * 1000 + time.tv_nsec / 1000000);
}
