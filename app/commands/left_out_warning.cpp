#include "app/commands/left_out_warning.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

namespace ballservo {

void LeftOutWarning::add(const LeftOut& left_out, const std::string& source, long frame) {
  if (!left_out || pictures_++ > 0) return;
  example_ = fmt::format("{}, frame {}", source, frame);
  if (left_out.regions > 0) example_ += fmt::format(", {} smaller regions", left_out.regions);
  if (left_out.shorter_px > 0) example_ += fmt::format(", runs shorter than {} px", left_out.shorter_px);
}

void LeftOutWarning::say() const {
  if (pictures_ == 0) return;
  spdlog::warn(
      "{} picture{} had more regions of the balls' colours than are searched, and small balls may have been "
      "missed (left out in {}): colours that the background has too? Teach them with --background",
      pictures_, pictures_ == 1 ? "" : "s", example_);
}

}  // namespace ballservo
