// The stages of one detection as pictures: the paper's figures 4, 2 (e to h) and 3.
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <utility>
#include <vector>

#include "perception/detector.hpp"

namespace ballservo {

/// (title, picture) in the order of the pipeline: source, classified, opened, closed, outlines and centre
/// votes, first circle and what it removes, ring pixels, estimate by votes with the reasons of rejection,
/// refined, then the vote histograms of the roundest region and of the least round one.
std::vector<std::pair<std::string, cv::Mat>> stage_pictures(const cv::Mat& bgr, const DetectionStages& stages,
                                                            const Detector& detector);

}  // namespace ballservo
