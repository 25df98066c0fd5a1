#include "app/peer/lockstep_socket.hpp"

#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <zmq.hpp>

#include "app/io/interrupt.hpp"
#include "calibration/base/numbers.hpp"

namespace ballservo {

namespace {

constexpr int linger_ms = 100;   // for the last word, where somebody listens
constexpr int look_ms = 20;      // after which a wait looks for Ctrl-C
constexpr int most_waiting = 2;  // messages that nobody has asked for yet
// ZeroMQ bounds a message's parts, not their number, and holds them until the last has come.
constexpr long most_growth_kb = 256 * 1024;

/// The most memory that the process ever had.
long peak_kb() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_maxrss;
}

bool is_address(const std::string& address) {
  const std::string prefix = "tcp://";
  const std::size_t colon = address.rfind(':');
  if (address.compare(0, prefix.size(), prefix) != 0 || colon <= prefix.size()) return false;
  const auto port = parse_integer(address.substr(colon + 1));
  return port && *port >= 0 && *port <= 65535;
}

}  // namespace

struct LockstepSocket::Line {
  zmq::context_t context{1};
  zmq::socket_t socket;
  LockstepParts envelope{};  // robot: who asked last and, up to an empty part, what is to be sent back
  std::string controller{};  // who asked first; everybody else is told so

  void send(const LockstepParts& head, const LockstepParts& parts) {
    for (const LockstepParts* some : {&head, &parts})
      for (const std::string& part : *some)
        socket.send(zmq::buffer(part),
                    &part == &parts.back() ? zmq::send_flags::none : zmq::send_flags::sndmore);
  }
  LockstepParts receive() {
    LockstepParts parts;
    zmq::message_t part;
    do {
      (void)socket.recv(part);
      if (parts.size() <= most_frames + 4) parts.push_back(part.to_string());
    } while (part.more());
    return parts;
  }
  /// Leaves the message; false: it is none of the controller's.
  bool open(LockstepParts& parts) {
    const auto end = std::find(parts.begin(), parts.end(), "");
    if (end == parts.begin() || end == parts.end() || end + 1 == parts.end()) return false;
    const LockstepParts head(parts.begin(), end + 1);
    parts.erase(parts.begin(), end + 1);
    if (controller.empty()) controller = head.front();
    if (head.front() == controller) {
      envelope = head;
      return true;
    }
    LockstepAnswer taken;
    taken.outcome = "fault";
    taken.text = "another controller drives this robot already";
    send(head, parts_of(taken));
    return false;
  }
};

LockstepSocket::LockstepSocket(Side side, const Options& options)
    : side_(side), options_(options), line_(new Line), may_send_(side == Side::controller) {
  const auto refuse = [&](const std::string& why) {
    throw InputError(options.option, "'" + options.address + "'" + why,
                     "tcp://HOST:PORT with a host of this network and a free port from 1 to 65535");
  };
  if (!is_address(options.address)) refuse("");
  try {
    line_->socket = {line_->context, side == Side::controller ? ZMQ_REQ : ZMQ_ROUTER};
    zmq::socket_t& socket = line_->socket;
    socket.set(zmq::sockopt::linger, linger_ms);
    socket.set(zmq::sockopt::sndtimeo, linger_ms);
    socket.set(zmq::sockopt::rcvhwm, most_waiting);
    socket.set(zmq::sockopt::maxmsgsize, static_cast<std::int64_t>(options.most_bytes));
    if (side == Side::robot) {
      socket.bind(options.address);
      return;
    }
    // The last word goes out even without an answer; one that comes after it is not taken for the next one.
    socket.set(zmq::sockopt::req_relaxed, true);
    socket.set(zmq::sockopt::req_correlate, true);
    socket.connect(options.address);
  } catch (const zmq::error_t& error) {
    refuse(fmt::format(" ({})", error.what()));
  }
}

LockstepSocket::~LockstepSocket() = default;

std::string LockstepSocket::address() const { return line_->socket.get(zmq::sockopt::last_endpoint); }

void LockstepSocket::send(const LockstepParts& parts) {
  if (!may_send_) return;
  may_send_ = side_ == Side::controller;
  line_->send(line_->envelope, parts);
}

LockstepParts LockstepSocket::receive() {
  using Steady = std::chrono::steady_clock;
  const double within_s = heard_ ? options_.deadline_s : std::max(options_.first_s, options_.deadline_s);
  const auto deadline = Steady::now() + std::chrono::duration<double>(within_s);
  const long before_kb = peak_kb();
  zmq_pollitem_t item{line_->socket.handle(), 0, ZMQ_POLLIN, 0};
  while (true) {
    if (zmq_poll(&item, 1, look_ms) > 0) {
      LockstepParts parts = line_->receive();
      if (side_ == Side::controller || line_->open(parts)) {
        heard_ = may_send_ = true;
        return parts;
      }
    }
    if (!heard_) throw_if_interrupted();
    if (interrupt_requested()) throw PeerGone("the run was interrupted", "interrupted");
    if (peak_kb() > before_kb + most_growth_kb)
      throw PeerGone(options_.address + " sends a message without an end");
    if (Steady::now() < deadline) continue;
    // ZeroMQ gives a line up on which it was sent too large a part: the last word needs another.
    if (side_ == Side::controller) {
      line_->socket.disconnect(options_.address);
      line_->socket.connect(options_.address);
    }
    throw PeerGone(fmt::format("{} {} {:g} s (parts of more than {} bytes are not read)", options_.address,
                               heard_ ? "was silent for" : "has not answered within", within_s,
                               options_.most_bytes));
  }
}

}  // namespace ballservo
