// Which of the colours in some pictures a class request means.
#pragma once

#include <vector>

#include "calibration/base/fault.hpp"
#include "calibration/teaching/learn_colors.hpp"

namespace ballservo {

/// The groups that are balls. Throws Refusal where none is, with the `--at` that settles it.
std::vector<ColorGroup> ball_groups(std::vector<ColorGroup> groups,
                                    const std::vector<ColorPicture>& pictures);

/// What speaks against a group's being a ball, in words; empty where nothing does.
std::string doubt_about(const ColorGroup& group, const std::vector<ColorPicture>& pictures);

/// What else the request's pictures show that is as surely a ball, in words, where the class's name does not
/// say which colour is meant; empty where it does or nothing is.
std::string doubt_about_choice(const ClassRequest& request, const ColorGroup& chosen,
                               std::vector<ColorGroup> groups, const std::vector<ColorPicture>& pictures);

/// The group that `request` means, of those that its pictures show. Throws Refusal (see learn_classes).
ColorGroup chosen_group(const ClassRequest& request, std::vector<ColorGroup> groups,
                        const std::vector<ColorPicture>& pictures);

/// The group of the ball that the user points at, with every candidate that has its colour.
ColorGroup pointed_group(const ClassRequest& request, const std::vector<BallCandidate>& candidates,
                         const std::vector<ColorPicture>& pictures);

/// A fault where a request's name is none for a class, or that of a request before it.
void check_class_name(const std::vector<ClassRequest>& requests, std::size_t which, FaultList& faults);

/// Adds what is wrong with the requests to `faults`.
void check_requests(const std::vector<ClassRequest>& requests, const std::vector<ColorPicture>& pictures,
                    FaultList& faults);

}  // namespace ballservo
