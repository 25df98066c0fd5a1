// Tracks for other programs as they are followed: a line of JSON a picture, as data/stream.schema.json says.
#pragma once

#include <netinet/in.h>

#include <chrono>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "app/io/image_source.hpp"
#include "calibration/base/system_file.hpp"
#include "perception/tracking/tracker.hpp"

namespace ballservo {

/// What the wall clock showed then, in seconds since 1970.
double unix_time_s(std::chrono::steady_clock::time_point at = std::chrono::steady_clock::now());

/// A track as a line names it; it has its total covariance.
nlohmann::ordered_json track_json(const Track& track, const ColorTable& colors);

/// The line of a picture, with its newline; `tracks` have their total covariance. What is not known is null.
std::string stream_line(const Frame& frame, const std::vector<Track>& tracks, const ColorTable& colors,
                        double sent_unix_s);

/// Where the lines go.
class TrackStream {
 public:
  /// "-", standard output, or "udp:HOST:PORT" (an IPv6 address in brackets). Throws InputError.
  explicit TrackStream(const std::string& to);

  /// Sends a line at once. False where nobody can read standard output any longer. A datagram that cannot
  /// leave (no route, a full queue, more than 65507 bytes) is counted, and nothing waits for it.
  bool send(const std::string& line);
  /// Why datagrams did not leave, and how many; empty where all did.
  std::string lost() const;

 private:
  std::optional<Descriptor> socket_;  // none: standard output
  sockaddr_storage address_{};
  socklen_t address_bytes_ = 0;
  long lost_ = 0, sent_ = 0;
  int error_ = 0;
};

}  // namespace ballservo
