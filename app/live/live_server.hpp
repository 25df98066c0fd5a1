// The page's server: a few files by HTTP and one WebSocket a client, on one thread of its own.
#pragma once

#include <chrono>
#include <memory>
#include <string>

#include "app/live/live_exchange.hpp"

namespace ballservo {

struct LiveServerOptions {
  std::string address = "127.0.0.1";          ///< of the interface: an IP address
  int port = 0;                               ///< 0: one that is free
  std::chrono::milliseconds patience{10000};  ///< for a request to come in whole, and a handshake
};

/// Serves from the constructor on, until it is destroyed. A client is sent the newest moment once it says
/// that it has painted the last one, and nothing in between; who does not read, holds up nobody. Whatever
/// clients send, nothing but the page's files and the session's answers is given out.
class LiveServer {
 public:
  /// Throws InputError where the address is none of this machine, or the port is taken.
  LiveServer(const LiveServerOptions& options, LiveExchange& exchange);
  ~LiveServer();

  /// Where the page is; with a secret in it unless only this machine can reach it.
  const std::string& url() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ballservo
