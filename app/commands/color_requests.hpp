// What `calibrate colors` is asked on its command line: which pictures, which classes, where the balls are.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "calibration/base/fault.hpp"
#include "calibration/teaching/learn_colors.hpp"

namespace ballservo {

/// The pictures of the command line, each read once, however often it is named.
class PictureSet {
 public:
  /// The indices of the pictures that the sources name.
  std::vector<std::size_t> add(const std::vector<std::string>& sources);

  /// One that is in the other set, too, if there is one.
  std::optional<std::filesystem::path> shared_with(const PictureSet& other) const;

  /// All of them; every one that cannot be read is a fault.
  std::vector<ColorPicture> read(double max_pixels) const;

 private:
  std::vector<std::filesystem::path> files_;
  std::map<std::filesystem::path, std::size_t> index_;
};

/// NAME=IMAGE[,IMAGE...], each.
std::vector<ClassRequest> parse_classes(const std::vector<std::string>& texts, PictureSet& pictures,
                                        FaultList& faults);

/// NAME=CX,CY,R; a fault of `option` otherwise.
std::optional<std::pair<std::string, PointedBall>> parse_ball(const char* option, const std::string& text,
                                                              FaultList& faults);

/// Gives the requests the balls that --at points at.
void parse_pointed_balls(const std::vector<std::string>& texts, std::vector<ClassRequest>& requests,
                         FaultList& faults);

}  // namespace ballservo
