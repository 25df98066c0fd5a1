#include "calibration/teaching/box_trainer.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "calibration/base/fault.hpp"
#include "calibration/color/color_file.hpp"
#include "calibration/teaching/class_table.hpp"
#include "calibration/teaching/clear_picture.hpp"

namespace ballservo {
namespace {

constexpr std::size_t least_frames = 10;  // below it the source was too short, or the ball was not there
constexpr double drift = 0.8;  // of the box's radius: how far the ball may lie from where it was seen last
constexpr double min_box_ratio = 0.4, max_box_ratio = 1.7;  // ball to box
constexpr int patience = 15;  // frames without the ball, after which the box goes back to where it was drawn
constexpr double window_radii = 2.5;       // half side of what is looked at, in radii of the box
constexpr double working_radius_px = 40;   // larger boxes are looked at at a reduced scale
constexpr double least_box_log_odds = -2;  // the user says that a ball is there
constexpr double majority = 0.6;           // of the balls seen must have one colour

}  // namespace

BoxTrainer::BoxTrainer(std::string name, const PointedBall& box, const RegionSearchOptions& search)
    : name_(std::move(name)), box_(box), place_(box), search_(search) {
  FaultList faults;
  if (!is_class_name(name_)) faults.add("--box", "the name \"" + name_ + "\"", class_name_rule);
  if (!box.center_px.allFinite() || !(box.radius_px >= 5 && box.radius_px <= 1e5)) {
    faults.add("--box", fmt::format("{},{},{}", box.center_px.x(), box.center_px.y(), box.radius_px),
               "a centre in the picture and a radius of 5 px or more");
  }
  faults.throw_if_any();
  search_.min_radius_px = std::max(4.0, min_box_ratio * std::min(box.radius_px, working_radius_px));
}

bool BoxTrainer::look(const cv::Mat& bgr, int frame) {
  if (!size_.empty() && bgr.size() != size_) {
    throw InputError(
        "--from",
        fmt::format("frames of {} x {} and {} x {} pixels", size_.width, size_.height, bgr.cols, bgr.rows),
        "one size");
  }
  size_ = bgr.size();
  if (!(box_.center_px.x() >= 0 && box_.center_px.y() >= 0 && box_.center_px.x() < bgr.cols &&
        box_.center_px.y() < bgr.rows)) {
    throw InputError("--box", fmt::format("{},{},{}", box_.center_px.x(), box_.center_px.y(), box_.radius_px),
                     fmt::format("a centre inside the {} x {} px of the frames", bgr.cols, bgr.rows));
  }
  ++looked_at_;
  const double half = window_radii * box_.radius_px;
  const cv::Rect window =
      cv::Rect(static_cast<int>(place_.center_px.x() - half), static_cast<int>(place_.center_px.y() - half),
               static_cast<int>(2 * half), static_cast<int>(2 * half)) &
      cv::Rect({0, 0}, bgr.size());
  const double scale = std::min(1.0, working_radius_px / box_.radius_px);
  search_.max_working_pixels = std::max(1e4, scale * scale * window.area());
  const cv::Mat view = clear_picture(bgr(window));
  const RoundRegions found = find_round_regions(view, search_);
  const Eigen::Vector2d corner(window.x, window.y);
  BallCandidate best;
  double best_score = 0;
  for (BallCandidate& candidate : ball_candidates({"", view}, static_cast<std::size_t>(frame), found)) {
    if (candidate.region.evidence.log_odds() < least_box_log_odds) continue;
    const double away = (candidate.region.center_px + corner - place_.center_px).norm() / box_.radius_px;
    const double ratio = candidate.region.radius_px / box_.radius_px;
    if (away > drift || ratio < min_box_ratio || ratio > max_box_ratio) continue;
    const double score = candidate.region.fit_ratio() * std::min(1.0, ratio) * (1 - 0.5 * away);
    if (score > best_score) best_score = score, best = std::move(candidate);
  }
  if (best_score == 0) {
    if (++missed_ >= patience) place_ = box_;
    return false;
  }
  missed_ = 0;
  best.samples = samples_inside(bgr(window), best.region, found.scale);
  best.region.center_px += corner;
  best.region.mask.release();  // its samples are taken
  const Shown shown{frame, bgr.clone(), place_, {best.region.center_px, best.region.radius_px}};
  shown_.resize(std::min<std::size_t>(1, shown_.size()));
  shown_.push_back(shown);
  place_.center_px = best.region.center_px;
  cv::Mat1b off(bgr.size(), 255);
  cover(off, best.region);
  count_cells(bgr, off, off_ball_);
  count_cells(bgr, {}, all_);
  balls_.push_back(std::move(best));
  return true;
}

LearntColors BoxTrainer::finish(const std::vector<ColorPicture>& background) const {
  const auto found = static_cast<int>(balls_.size());
  if (balls_.size() < least_frames) {
    throw Refusal(fmt::format(
        "class {}: a round coloured thing was in the box in only {} of {} frames; {} are needed. "
        "Hold the ball so that "
        "it fills the box at {:.0f},{:.0f} of radius {:.0f} px, in even light, before something "
        "of another colour; "
        "or move the box to where the ball is",
        name_, found, looked_at_, least_frames, box_.center_px.x(), box_.center_px.y(), box_.radius_px));
  }
  std::vector<ColorGroup> groups = color_groups(balls_, all_);
  const auto most = std::max_element(groups.begin(), groups.end(), [](const auto& a, const auto& b) {
    return a.balls.size() < b.balls.size();
  });
  if (most == groups.end() || static_cast<double>(most->balls.size()) < majority * found ||
      most->balls.size() < least_frames) {
    std::string seen;
    for (const ColorGroup& group : groups)
      seen += fmt::format("{}{} in {} frames", seen.empty() ? "" : ", ", group.word, group.balls.size());
    throw Refusal(
        fmt::format("class {}: the things in the box had different colours ({}). Keep hands and "
                    "everything round but the ball out of it",
                    name_, seen));
  }
  LearntColors result;
  CellCounts elsewhere = off_ball_;
  for (const ColorPicture& picture : background) count_cells(picture.bgr, {}, elsewhere);
  result.table.background = occupied(elsewhere);
  add_class(result, name_, *most, true);
  std::vector<LearntCircle>& circles = result.circles[name_];
  std::sort(circles.begin(), circles.end(), [](const auto& a, const auto& b) { return a.frame < b.frame; });
  rebuild(result.table);
  return result;
}

}  // namespace ballservo
