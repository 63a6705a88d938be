#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <functional>
#include <stdexcept>
#include <string>
#include <thread>

#include "Adapters/Rendering/ImageEncoding.h"

namespace kerf::testing {

/// A camera in the network, as small as can be: sends JPEG pictures over HTTP on loopback, to one
/// reader after the other. What a real one does wrong it does on request.
class MjpegServer {
 public:
  /// @param picture the n-th one
  explicit MjpegServer(std::function<Image(int n)> picture) : picture_(std::move(picture)) {
    Open();
  }
  ~MjpegServer() { Close(); }

  std::string Url() const { return "http://127.0.0.1:" + std::to_string(port_) + "/live.mjpg"; }
  /// Sends nothing, but keeps the connection: a cable pulled behind the camera.
  void SetSilent(bool silent) { silent_ = silent; }
  /// Ends the connection and answers no more.
  void Close() {
    stop_ = true;
    if (thread_.joinable()) thread_.join();
    if (listener_ >= 0) close(listener_);
    listener_ = -1;
  }
  /// Answers again, at the same address.
  void Open() {
    listener_ = socket(AF_INET, SOCK_STREAM, 0);
    const int on = 1;
    setsockopt(listener_, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    address.sin_port = htons(port_);
    socklen_t size = sizeof address;
    auto* name = reinterpret_cast<sockaddr*>(&address);
    if (bind(listener_, name, size) != 0 || listen(listener_, 4) != 0)
      throw std::runtime_error("no port for the test's camera");
    getsockname(listener_, name, &size);
    port_ = ntohs(address.sin_port);
    stop_ = false;
    thread_ = std::thread([this] { Serve(); });
  }
  int Connections() const { return connections_; }

 private:
  void Serve() {
    while (!stop_) {
      if (!Readable(listener_)) continue;
      const int reader = accept(listener_, nullptr, nullptr);
      if (reader < 0) continue;
      ++connections_;
      Send(reader,
           "HTTP/1.0 200 OK\r\nContent-Type: multipart/x-mixed-replace;boundary=picture\r\n\r\n");
      while (!stop_ && !Left(reader)) {
        std::this_thread::sleep_for(std::chrono::milliseconds(40));
        if (!silent_ && !SendPicture(reader)) break;
      }
      close(reader);
    }
  }
  static bool Readable(int socket) {
    fd_set set;
    FD_ZERO(&set);
    FD_SET(socket, &set);
    timeval wait{0, 20000};
    return select(socket + 1, &set, nullptr, nullptr, &wait) > 0;
  }
  /// The request is read on the way; nothing to read any more means that the reader has gone.
  static bool Left(int socket) {
    char request[4096];
    return recv(socket, request, sizeof request, MSG_DONTWAIT) == 0;
  }
  static bool Send(int socket, const std::string& bytes) {
    return send(socket, bytes.data(), bytes.size(), MSG_NOSIGNAL) ==
           static_cast<ssize_t>(bytes.size());
  }
  bool SendPicture(int socket) {
    const auto jpeg = EncodeJpeg(picture_(sent_++), 95);
    return Send(socket, "--picture\r\nContent-Type: image/jpeg\r\nContent-Length: " +
                            std::to_string(jpeg.size()) + "\r\n\r\n" +
                            std::string(jpeg.begin(), jpeg.end()) + "\r\n");
  }

  std::function<Image(int)> picture_;
  int listener_ = -1, sent_ = 0;
  std::uint16_t port_ = 0;
  std::atomic<bool> stop_{false}, silent_{false};
  std::atomic<int> connections_{0};
  std::thread thread_;
};

}  // namespace kerf::testing
