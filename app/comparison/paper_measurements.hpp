// What the paper says of its first stages, measured: votes, their quality, boundaries, classes, times.
#pragma once

#include <nlohmann/json.hpp>

#include "app/comparison/pictures/plan.hpp"

namespace ballservo {

/// Medians over a few frames of the plan's defaults with things of the ball's colour in them:
/// `votes`, `votes_largest`    N_votes of whole balls: median, most
/// `quality_ball`              Q_c of a whole ball's region
/// `quality_touching`          of a ball whose region holds a bar that touches it, too
/// `quality_other`             of regions of the same colour that are not round
/// `boundary_px`               pixels on the boundaries of all regions of the colour
/// `edge_px`                   luminance edges (Canny, 50 and 150) in the same pictures
/// `class_counts`, `class_right`, `class_wrong`   lists: the part of the balls' pixels that are told to be of
///                             their own class, or of another, with so many classes at once
/// `timing`: {`read_us`, `segment_us`, `vote_us`, `detect_us`}   one thread, a picture of 1024x683 (0.7 Mpix)
nlohmann::json measure_paper_claims(const ComparisonPlan& plan);

}  // namespace ballservo
