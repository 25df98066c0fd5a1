// One side of a lockstep's line: a ZeroMQ socket on which nobody waits for ever.
#pragma once

#include <memory>
#include <string>

#include "app/peer/lockstep_messages.hpp"

namespace ballservo {

/// Speaks and listens by turns.
class LockstepSocket {
 public:
  /// controller: connects, and speaks first (REQ). robot: is at home there, and answers the first who asks
  /// (ROUTER); whoever else asks is refused.
  enum class Side { controller, robot };

  struct Options {
    std::string option = "--peer";  ///< by which messages name the address
    std::string address;            ///< tcp://HOST:PORT; port 0 of a robot: any that is free
    double deadline_s = 1;          ///< of each message; the first may take `first_s`
    double first_s = 30;
    std::size_t most_bytes = most_header_bytes;  ///< of a part; who sends more is cut off
  };
  /// Throws InputError for an address that cannot be.
  LockstepSocket(Side side, const Options& options);
  ~LockstepSocket();

  /// With the port that was free.
  std::string address() const;

  /// Does nothing where the other side is not to be told anything now: a robot that was not asked.
  void send(const LockstepParts& parts);

  /// Throws PeerGone where none comes in time, or the user interrupts.
  LockstepParts receive();

 private:
  struct Line;
  Side side_;
  Options options_;
  std::unique_ptr<Line> line_;
  bool heard_ = false, may_send_ = false;
};

}  // namespace ballservo
