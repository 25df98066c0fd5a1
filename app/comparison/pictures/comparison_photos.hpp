// Frames of a comparison with what the methods saw in them.
#pragma once

#include <functional>
#include <opencv2/core.hpp>

#include "app/comparison/comparison.hpp"

namespace ballservo {

/// Shows frame `frame` of a condition again.
using ShowFrame = std::function<ComparisonPicture(std::size_t condition, int frame)>;

/// The surroundings of the ball, enlarged.
cv::Mat example_photo(const ComparisonPicture& picture);

/// The same with every method's outline: white the truth, grey the votes, orange the paper's fits, blue the
/// exact ones, green the algebraic, magenta the peers.
cv::Mat outlines_photo(const ComparisonPicture& picture, const ComparisonRecord& record,
                       const MethodList& methods);

}  // namespace ballservo
