// What the other side of a lockstep says: a part a line, the first one the header. What passes is within its
// bounds, and comes back as it was written.
#include <cmath>
#include <sstream>

#include "app/peer/lockstep_messages.hpp"
#include "tests/fuzz/fuzz_folder.hpp"

using namespace ballservo;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  LockstepParts parts;
  std::istringstream lines(fuzz::text_of(data, size));
  for (std::string line; std::getline(lines, line);) parts.push_back(line);
  const bool pictures = parts.size() > 1;
  const AnswerBounds bounds{0.58, 0.02, pictures ? ImageSize{2, 1} : ImageSize{0, 0}, 0.5, 16};
  try {
    const LockstepRequest request = request_of(parts);
    fuzz::require(std::isfinite(request.command.v_mps + request.until_s), "numbers that are finite");
    fuzz::require(request_of(parts_of(request)).until_s == request.until_s, "a request that reads back");
  } catch (const PeerGone&) {
  }
  try {
    const LockstepAnswer answer = answer_of(parts, bounds);
    if (!answer.outcome.empty()) return 0;
    for (const LockstepFrame& frame : answer.frames)
      fuzz::require(frame.frame.arrives_s <= answer.state.time_s && frame.ball.p_CB.allFinite(),
                    "frames within bounds");
    fuzz::require(answer_of(parts_of(answer), bounds).state.time_s == answer.state.time_s,
                  "an answer that reads back");
  } catch (const PeerGone&) {
  }
  return 0;
}
