// Which of the colours in some pictures a class request means.
#pragma once

#include <vector>

#include "calibration/color/learn_colors.hpp"
#include "calibration/files/fault.hpp"

namespace ballservo {

/// The group that `request` means, of those that its pictures show. Throws Refusal (see learn_classes).
ColorGroup chosen_group(const ClassRequest& request, std::vector<ColorGroup> groups,
                        const std::vector<ColorPicture>& pictures, const LearnOptions& options);

/// The group of the ball that the user points at, with every candidate that has its colour.
ColorGroup pointed_group(const ClassRequest& request, const std::vector<BallCandidate>& candidates,
                         const std::vector<ColorPicture>& pictures, const LearnOptions& options);

/// Adds what is wrong with the requests to `faults`.
void check_requests(const std::vector<ClassRequest>& requests, const std::vector<ColorPicture>& pictures,
                    FaultList& faults);

}  // namespace ballservo
