#include "app/io/track_stream.hpp"

#include <fmt/format.h>
#include <netdb.h>
#include <sys/socket.h>

#include <cerrno>
#include <cstring>
#include <memory>

#include "app/io/messages.hpp"
#include "app/io/run_files.hpp"
#include "calibration/base/fault.hpp"
#include "calibration/base/numbers.hpp"

namespace ballservo {
namespace {

using ordered_json = nlohmann::ordered_json;

/// Fills in the address of "HOST:PORT"; false where there is none.
bool find_address(const std::string& text, sockaddr_storage& address, socklen_t& bytes) {
  const std::size_t colon = text.rfind(':');
  if (colon == std::string::npos) return false;
  std::string host = text.substr(0, colon);
  const auto port = parse_integer(text.substr(colon + 1));
  if (host.size() > 2 && host.front() == '[' && host.back() == ']') host = host.substr(1, host.size() - 2);
  if (host.empty() || !port || *port < 1 || *port > 65535) return false;
  addrinfo hints{}, *found = nullptr;
  hints.ai_socktype = SOCK_DGRAM;
  if (getaddrinfo(host.c_str(), std::to_string(*port).c_str(), &hints, &found) != 0) return false;
  const std::unique_ptr<addrinfo, decltype(&freeaddrinfo)> owner(found, freeaddrinfo);
  std::memcpy(&address, found->ai_addr, found->ai_addrlen);
  bytes = found->ai_addrlen;
  return true;
}

}  // namespace

ordered_json track_json(const Track& track, const ColorTable& colors) {
  const OutlineEllipse& outline = track.ball.outline;
  ordered_json ball = {{"track_id", track.id},
                       {"class", colors.name_of(track.color_class)},
                       {"state", track_state_name(track.state)},
                       {"quality", track.ball.quality},
                       {"outline_px", {outline.center_px.x(), outline.center_px.y(), outline.radius_px}},
                       {"p_m", nullptr},
                       {"covariance_m2", nullptr}};
  if (!track.ball.position) return ball;
  const auto& [p, s] = *track.ball.position;
  ball["p_m"] = {p.x(), p.y(), p.z()};
  ball["covariance_m2"] = {
      {s(0, 0), s(0, 1), s(0, 2)}, {s(0, 1), s(1, 1), s(1, 2)}, {s(0, 2), s(1, 2), s(2, 2)}};
  return ball;
}

double unix_time_s(std::chrono::steady_clock::time_point at) {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  return std::chrono::duration<double>(now - (std::chrono::steady_clock::now() - at)).count();
}

std::string stream_line(const Frame& frame, const std::vector<Track>& tracks, const ColorTable& colors,
                        double sent_unix_s) {
  ordered_json line = {{"time_s", frame.time_s},     {"captured_unix_s", nullptr},
                       {"sent_unix_s", sent_unix_s}, {"frame", frame.index},
                       {"source", frame.source},     {"balls", ordered_json::array()}};
  if (frame.captured_unix_s) line["captured_unix_s"] = *frame.captured_unix_s;
  for (const Track& track : tracks) line["balls"].push_back(track_json(track, colors));
  return line.dump(-1, ' ', false, ordered_json::error_handler_t::replace) + "\n";
}

TrackStream::TrackStream(const std::string& to) {
  if (to == standard_output) {
    give_stdout_to_json();
    return;
  }
  const std::string prefix = "udp:";
  if (to.compare(0, prefix.size(), prefix) != 0 ||
      !find_address(to.substr(prefix.size()), address_, address_bytes_))
    throw InputError("--stream", "'" + to + "'",
                     "-, or udp:HOST:PORT with a host that can be found and a port from 1 to 65535");
  socket_.emplace(socket(address_.ss_family, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (socket_->number() < 0)
    throw InputError("--stream", system_error_text(errno), "a machine that can send to " + to);
  const int yes = 1;  // of use for a broadcast address alone
  setsockopt(socket_->number(), SOL_SOCKET, SO_BROADCAST, &yes, sizeof yes);
}

bool TrackStream::send(const std::string& line) {
  if (!socket_) {
    errno = 0;
    write_json(line);
    if (!stdout_failed()) return true;
    if (errno == EPIPE) return false;
    throw InputError("stdout", system_error_text(errno), "a place that can be written");
  }
  ++sent_;
  if (sendto(socket_->number(), line.data(), line.size(), MSG_NOSIGNAL,
             reinterpret_cast<const sockaddr*>(&address_), address_bytes_) < 0) {
    ++lost_;
    error_ = errno;
  }
  return true;
}

std::string TrackStream::lost() const {
  if (lost_ == 0) return {};
  return fmt::format("{} of {} lines did not leave: {}", lost_, sent_, system_error_text(error_));
}

}  // namespace ballservo
