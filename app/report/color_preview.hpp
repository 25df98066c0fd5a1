// The paper's figure 1: how colours were learnt from a picture.
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "calibration/teaching/box_trainer.hpp"
#include "calibration/teaching/learn_colors.hpp"

namespace ballservo {

/// A panel: its name for a file ("b_segments"), its caption, and the picture (8-bit BGR).
struct PreviewPanel {
  std::string name, caption;
  cv::Mat picture;
};

/// The six panels for one of the pictures that were learnt from: (a) the picture and (b) its chroma,
/// smoothed, at one lightness, both with the circles that were accepted, (c) the chroma of all samples over
/// (a, b) of Lab, (d) the groups of cells that became classes, (e) the class of every pixel, the others grey,
/// and (f) the table at six lightnesses.
std::vector<PreviewPanel> color_preview(const LearntColors& colors, const std::vector<ColorPicture>& pictures,
                                        std::size_t picture);

/// The same for a frame of live material: (a) with the square that the ball was held in and the ball that was
/// found there, then (c) to (f).
std::vector<PreviewPanel> box_preview(const ColorTable& colors, const BoxTrainer::Shown& shown);

/// Panels (c), (d) and (f) alone, from a colours file: the groups are found anew from its histograms.
std::vector<PreviewPanel> color_preview(const ColorTable& colors);

/// The panels side by side with their captions.
cv::Mat preview_figure(const std::vector<PreviewPanel>& panels);

}  // namespace ballservo
