#include "app/live/board_lessons.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "app/report/camera_report.hpp"
#include "calibration/base/fault.hpp"

namespace ballservo {
namespace {

// Of a board that is asked for: its tilt (30 degrees), what stays free of the picture's width, and how often
// its place is corrected.
constexpr double asked_tilt_rad = 0.52, edge = 0.02;
constexpr int rounds = 10;
constexpr int thirds = 3;             // of the picture, each way
constexpr double tilt_sine = 0.34;    // 20 degrees
constexpr double filling = 0.5;       // of the picture's width or height, that one board at least is to span
constexpr double far_and_near = 1.5;  // ratio of the largest board's span to the smallest's

int third_of(double place_px, int side_px) {
  return std::clamp(static_cast<int>(thirds * place_px / side_px), 0, thirds - 1);
}

std::string place_name(const Eigen::Vector2d& place_px, ImageSize size) {
  static const char* const names[thirds][thirds] = {
      {"at the upper left", "at the top", "at the upper right"},
      {"at the left", "in the middle", "at the right"},
      {"at the lower left", "at the bottom", "at the lower right"}};
  return names[third_of(place_px.y(), size.height_px)][third_of(place_px.x(), size.width_px)];
}

/// The middle of that ninth of the picture in which the fewest corners lie; of several the picture's middle,
/// then its corners.
Eigen::Vector2d emptiest_place(ImageSize size, const std::vector<BoardView>& views) {
  std::array<long, thirds * thirds> corners{};
  for (const BoardView& view : views)
    for (const Eigen::Vector2d& corner : view.corners_px)
      ++corners[static_cast<std::size_t>(thirds * third_of(corner.y(), size.height_px) +
                                         third_of(corner.x(), size.width_px))];
  std::size_t emptiest = 4;
  for (const std::size_t ninth : {0, 8, 2, 6, 1, 7, 3, 5})
    if (corners[ninth] < corners[emptiest]) emptiest = ninth;
  return {(static_cast<double>(emptiest % thirds) + 0.5) / thirds * size.width_px - 0.5,
          (static_cast<double>(emptiest / thirds) + 0.5) / thirds * size.height_px - 0.5};
}

/// Part of the picture's width or height that the board spans, whichever is more.
double span_of(const BoardView& view, ImageSize size) {
  Eigen::AlignedBox2d box;
  for (const Eigen::Vector2d& corner : view.corners_px) box.extend(corner);
  return std::max(box.sizes().x() / size.width_px, box.sizes().y() / size.height_px);
}

const std::array<const char*, 4> side_names{"right side", "upper edge", "left side", "lower edge"};

/// The side of the board that is to be turned towards the camera: that of which the fewest boards have it.
/// Without poses each in turn.
std::size_t side_to_tilt(std::size_t boards, const std::vector<BoardPose>* poses) {
  if (poses == nullptr) return boards % side_names.size();
  std::array<int, 4> counts{};
  for (const BoardPose& pose : *poses) {
    Eigen::Vector3d normal = board_normal(pose);  // the right side is nearer where it points to the right
    if (normal.z() < 0) normal = -normal;
    const Eigen::Vector4d towards(normal.x(), -normal.y(), -normal.x(), normal.y());
    for (std::size_t k = 0; k < counts.size(); ++k) counts[k] += towards[k] > tilt_sine;
  }
  return static_cast<std::size_t>(std::min_element(counts.begin(), counts.end()) - counts.begin());
}

/// Until there is a fit: 53 degrees across the longer side.
Camera camera_before(ImageSize size) {
  const double f_px = std::max(size.width_px, size.height_px);
  return Camera(
      {LensModel::pinhole, size, f_px, f_px, (size.width_px - 1) / 2.0, (size.height_px - 1) / 2.0, {}});
}

/// The outermost points from the middle between them.
std::array<Eigen::Vector3d, 4> corners_of(const Board& board) {
  Eigen::Vector3d high = Eigen::Vector3d::Zero();  // the first point is the origin
  for (const Eigen::Vector3d& point : board.points()) high = high.cwiseMax(point);
  const double x = high.x() / 2, y = high.y() / 2;
  return {{{-x, -y, 0}, {x, -y, 0}, {x, y, 0}, {-x, y, 0}}};
}

/// Says how far away it is to be, and how much of the picture the board then spans.
std::string distance_words(ImageSize size, const std::vector<BoardView>& views, double& span) {
  double largest = 0, smallest = std::numeric_limits<double>::infinity();
  for (const BoardView& view : views) {
    largest = std::max(largest, span_of(view, size));
    smallest = std::min(smallest, span_of(view, size));
  }
  if (largest < filling) {
    span = filling;
    return ", so near that it fills half of the picture";
  }
  if (largest >= far_and_near * smallest) return "";
  span = largest / 2;
  return ", twice as far away as it was";
}

}  // namespace

BoardLessons::BoardLessons(const std::string& board_text, double square_m)
    : board_text_(board_text), board_(parse_board(board_text, square_m)) {}

/// Why a picture says nothing of the board; empty where it does.
std::string BoardLessons::fault_of(const BoardFinding& finding, ImageSize size) const {
  if (!taken_.empty() && !(size == size_))
    return fmt::format("The pictures are {}x{} now, those that were taken {}x{}: stop, and start again.",
                       size.width_px, size.height_px, size_.width_px, size_.height_px);
  if (finding.seen && taken_.empty()) {
    const auto [longer, shorter] = *finding.seen;
    const int named_longer = std::max(board_.columns, board_.rows);
    const int named_shorter = std::min(board_.columns, board_.rows);
    if (longer >= named_longer && shorter >= named_shorter && longer + shorter > named_longer + named_shorter)
      return fmt::format(
          "A chessboard of {0}x{1} inner corners is seen, not {2}: if that is right, stop, and start "
          "with chessboard:{0}x{1}.",
          longer, shorter, board_text_);
  }
  if (!finding.view) return fmt::format("No board in this picture: {}.", finding.reason);
  return "";
}

BoardLessons::Seen BoardLessons::look(BoardFinding finding, ImageSize size, double time_s) {
  newest_.reset();
  if (taken_.empty()) size_ = size;
  words_ = fault_of(finding, size);
  if (!words_.empty()) {
    still_.reset();
    return Seen::nothing;
  }
  newest_ = std::move(finding.view);
  const BoardView& view = *newest_;
  const auto is_at = [&](const BoardView& other) {
    return mean_motion_px(view, other) <= new_motion * size.width_px;
  };
  if (given_back_ && !is_at(*given_back_)) given_back_.reset();
  if (!still_ || mean_motion_px(view, still_->view) > still_motion * size.width_px)
    still_ = {view, time_s, 0};
  ++still_->pictures;
  const bool is_still = still_->pictures >= still_pictures && time_s - still_->since_s >= still_s;
  if (given_back_ || std::any_of(taken_.begin(), taken_.end(), is_at)) {
    words_ = "This place is done: hold the board elsewhere, or tilt it otherwise.";
    return is_still ? Seen::known : Seen::moving;
  }
  if (taken_.size() == most_taken) {
    words_ = fmt::format("{} pictures are enough: save the camera.", most_taken);
    return Seen::known;
  }
  words_ = "Hold the board still.";
  if (!is_still) return Seen::moving;
  taken_.push_back(view);
  taken_.back().name = fmt::format("picture {}", taken_.size());
  words_ = fmt::format("Picture {} is taken.", taken_.size());
  return Seen::taken;
}

void BoardLessons::undo() {
  if (taken_.empty()) throw Refusal("no picture of the board has been taken");
  given_back_ = std::move(taken_.back());
  taken_.pop_back();
}

bool BoardFit::is_good_enough() const {
  if (!calibration || boards < good_boards) return false;
  const auto &typical_mm = calibration->covered_ball_sigma_mm, &worst_mm = calibration->ball_sigma_mm;
  return typical_mm && *typical_mm <= good_mm && worst_mm && *worst_mm <= good_worst_mm;
}

std::optional<std::size_t> BoardFit::worst_place() const {
  std::optional<std::size_t> worst;
  for (std::size_t i = 0; map && i < map->sigma_mm.size(); ++i)
    if (map->sigma_mm[i] && (!worst || *map->sigma_mm[i] > *map->sigma_mm[*worst])) worst = i;
  return worst;
}

BoardFit fit_boards(ImageSize size, const std::vector<BoardView>& views,
                    const std::vector<LensModel>& models) {
  BoardFit fit;
  fit.boards = views.size();
  try {
    fit.calibration = calibrate_from_boards(size, views, models);
    fit.lacks = calibration_lacks(*fit.calibration);
    fit.map = ball_sigma_map(fit.calibration->camera, fit.calibration->covariance.parameters,
                             BoardFit::diameter_m, BoardFit::range_m);
  } catch (const std::exception& error) {  // Refusal, mostly
    fit.calibration.reset();
    fit.refused = error.what();
  }
  return fit;
}

std::vector<Eigen::Vector2d> outline_of(const AskedBoard& asked, const Board& board, const Camera& camera) {
  static const std::array<Eigen::Vector3d, 4> axes{{{0, 1, 0}, {1, 0, 0}, {0, -1, 0}, {-1, 0, 0}}};
  const Eigen::Matrix3d R_CB = Eigen::AngleAxisd(asked_tilt_rad, axes[asked.side]).toRotationMatrix();
  const std::array<Eigen::Vector3d, 4> corners = corners_of(board);
  const Eigen::Array2d size(camera.size().width_px, camera.size().height_px);
  const double free_px = edge * size.x();
  double range_m = 5 * corners[2].norm();
  Eigen::Array2d place_px = asked.place_px;
  std::vector<Eigen::Vector2d> outline;
  for (int round = 0; round < rounds; ++round) {  // nearer or farther, and into the picture
    const auto ray = camera.unproject(place_px.matrix());
    if (!ray) return {};
    outline.clear();
    Eigen::AlignedBox2d box;
    for (const Eigen::Vector3d& corner : corners) {
      const auto seen = camera.project(range_m * *ray + R_CB * corner);
      if (!seen) return {};
      outline.push_back(*seen);
      box.extend(*seen);
    }
    range_m *= (box.sizes().array() / size).maxCoeff() / asked.span;
    place_px += (free_px - box.min().array()).max(0) - (box.max().array() - (size - 1 - free_px)).max(0);
  }
  return outline;
}

BoardHint next_board(const Board& board, ImageSize size, const std::vector<BoardView>& views,
                     const BoardFit* fit) {
  BoardHint hint;
  const auto worst = fit != nullptr ? fit->worst_place() : std::nullopt;
  const BoardCalibration* const found = fit != nullptr && fit->calibration ? &*fit->calibration : nullptr;
  hint.place_px = worst ? fit->map->places_px[*worst] : emptiest_place(size, views);
  AskedBoard asked{hint.place_px, side_to_tilt(views.size(), found != nullptr ? &found->poses : nullptr)};
  hint.words = fmt::format(
      "Hold the board {} of the picture, its {} tilted towards the camera by 20 to 40 degrees{}",
      place_name(hint.place_px, size), side_names[asked.side], distance_words(size, views, asked.span));
  hint.outline_px = outline_of(asked, board, found != nullptr ? found->camera : camera_before(size));
  if (worst)
    hint.words += fmt::format(": there a ball at 1 m is uncertain by {:.1f} mm", *fit->map->sigma_mm[*worst]);
  hint.words += ".";
  return hint;
}

}  // namespace ballservo
