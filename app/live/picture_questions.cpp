#include "app/live/picture_questions.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "app/live/remedies.hpp"
#include "app/report/overlay.hpp"
#include "app/report/stage_pictures.hpp"
#include "calibration/base/statistics.hpp"

namespace ballservo {
namespace {

using Candidate = DetectionStages::Candidate;

constexpr std::size_t most_candidates = 60;

/// Darker but where a pixel has a class: there in the class' colour.
cv::Mat taught_picture(const cv::Mat& bgr, const ColorTable& colors) {
  if (colors.classes.empty()) return bgr;
  std::vector<cv::Vec3b> halves(1);  // of the classes' colours; of no class black
  for (std::size_t k = 1; k <= colors.classes.size(); ++k) {
    const cv::Scalar color = class_display_color(colors, static_cast<ClassIndex>(k));
    halves.push_back(cv::Vec3b(cv::Vec3d(color.val)) / 2);
  }
  cv::Mat picture(bgr.size(), bgr.type());
  std::transform(bgr.begin<cv::Vec3b>(), bgr.end<cv::Vec3b>(), picture.begin<cv::Vec3b>(),
                 [&](const cv::Vec3b& p) { return halves[colors.classify(p[0], p[1], p[2])] + p / 2; });
  return picture;
}

/// The circle that an outline nearly is.
OutlineEllipse circle_of(const Candidate& candidate) {
  const auto& outline =
      candidate.refined_outline_px.empty() ? candidate.estimate_outline_px : candidate.refined_outline_px;
  OutlineEllipse circle;
  if (outline.empty()) return circle;
  for (const Eigen::Vector2d& p : outline) circle.center_px += p / static_cast<double>(outline.size());
  for (const Eigen::Vector2d& p : outline)
    circle.radius_px += (p - circle.center_px).norm() / static_cast<double>(outline.size());
  return circle;
}

std::string percent(double fraction) { return fmt::format("{:.0f} %", 100 * fraction); }

std::string figures_of(const Candidate& candidate) {
  const OutlineSupport& support = candidate.support;
  return fmt::format(
      "edge on {} of the outline, colour in {} of the disc and in {} of a rim around it, {} hidden",
      percent(support.arc), percent(support.fill), percent(support.leak), percent(support.hidden));
}

nlohmann::json answer(bool ball, const std::string& text, const std::string& figures,
                      std::string_view remedy) {
  return {{"ball", ball}, {"text", text}, {"figures", figures}, {"remedy", std::string(remedy)}};
}

/// What becomes of the pixel's class, where nothing around it was looked at for a ball.
nlohmann::json why_no_candidate(const cv::Mat& bgr, const cv::Point& pixel, const DetectionStages& stages,
                                const ColorTable& colors) {
  const auto class_in = [&](const cv::Mat& classes) { return classes.at<ClassIndex>(pixel); };
  const auto remedy = [](const char* view) { return live_view(view)->remedy; };
  const cv::Vec3b& color = bgr.at<cv::Vec3b>(pixel);
  const std::string value = fmt::format("R {} G {} B {}", color[2], color[1], color[0]);
  const ClassIndex classified = class_in(stages.classified), closed = class_in(stages.closed);
  if (closed != no_class)
    return answer(false, fmt::format("this is {}, but its region gives no circle", colors.name_of(closed)),
                  value, remedy("votes"));
  if (classified == no_class)
    return answer(false, "no class has the colour of this pixel", value, remedy("classified"));
  return answer(false,
                fmt::format("this is {}, but too little of it hangs together", colors.name_of(classified)),
                value, remedy("opened"));
}

/// What the detector says of the point, whatever is followed there.
nlohmann::json why_not_found(const cv::Mat& bgr, const Eigen::Vector2d& point_px, Detector& detector) {
  const cv::Point pixel(cvRound(point_px.x()), cvRound(point_px.y()));
  if (!cv::Rect({0, 0}, bgr.size()).contains(pixel))
    return answer(false, "that is outside the picture", "", "");
  DetectionStages stages;
  detector.detect(bgr, {{0, 0}, bgr.size()}, &stages);  // as the tracker does
  const Candidate* best = nullptr;
  for (const Candidate& candidate : stages.candidates) {
    const OutlineEllipse circle = circle_of(candidate);
    if ((circle.center_px - point_px).norm() > circle.radius_px) continue;
    const auto rank = [](const Candidate& each) {
      return std::make_pair(each.accepted, each.support.quality());
    };
    if (best == nullptr || rank(candidate) > rank(*best)) best = &candidate;
  }
  if (best == nullptr) return why_no_candidate(bgr, pixel, stages, detector.colors());
  const OutlineEllipse circle = circle_of(*best);
  const std::string what = fmt::format("{} around ({:.0f}, {:.0f}), radius {:.0f} px",
                                       detector.colors().name_of(best->color_class), circle.center_px.x(),
                                       circle.center_px.y(), circle.radius_px);
  if (best->accepted) return answer(true, what + ": this is a ball", figures_of(*best), "");
  return answer(false, what + ": " + best->reason, figures_of(*best), remedy_of(best->reason));
}

}  // namespace

cv::Mat live_picture(const std::string& view, const SeenPicture& seen) {
  const LiveView* const known = live_view(view);
  if (known == nullptr) return {};
  if (!known->title.empty() && seen.stages != nullptr && seen.detector != nullptr) {
    for (const auto& [title, picture] : stage_pictures(seen.bgr, *seen.stages, *seen.detector)) {
      if (title.rfind(known->title, 0) == 0) return picture;
    }
  }
  return view == "taught" ? taught_picture(seen.bgr, seen.colors) : seen.bgr;
}

nlohmann::json candidates_json(const DetectionStages& stages, const ColorTable& colors) {
  nlohmann::json listed = nlohmann::json::array();
  for (const Candidate& candidate : stages.candidates) {
    if (listed.size() == most_candidates) break;
    const OutlineEllipse circle = circle_of(candidate);
    listed.push_back({{"class", colors.name_of(candidate.color_class)},
                      {"outline_px", {circle.center_px.x(), circle.center_px.y(), circle.radius_px}},
                      {"accepted", candidate.accepted},
                      {"reason", candidate.accepted ? "" : candidate.reason},
                      {"remedy", std::string(candidate.accepted ? "" : remedy_of(candidate.reason))}});
  }
  return listed;
}

nlohmann::json why_no_ball(const cv::Mat& bgr, const Eigen::Vector2d& point_px, Detector& detector,
                           const std::vector<Track>& tracks) {
  nlohmann::json said = why_not_found(bgr, point_px, detector);
  const auto known = std::find_if(tracks.begin(), tracks.end(), [&](const Track& track) {
    const OutlineEllipse& outline = track.ball.outline;
    return track.state != TrackState::coasting && (outline.center_px - point_px).norm() < outline.radius_px;
  });
  if (said["ball"] || known == tracks.end()) return said;
  return answer(true,
                fmt::format("track {} follows this ball, which passes with less for being known. Alone: {}",
                            known->id, said["text"].get<std::string>()),
                said["figures"], "");
}

std::string position_text(const BallPosition& position) {
  const Eigen::Vector3d ray = position.p_C.normalized();
  const double along_m = std::sqrt(std::max(0.0, ray.dot(position.covariance_m2 * ray)));
  const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - ray * ray.transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(across * position.covariance_m2 * across,
                                                            Eigen::EigenvaluesOnly);
  const double across_m = std::sqrt(std::max(0.0, axes.eigenvalues().maxCoeff()));
  // As many digits as mean something: 1.002 m +- 1.1 mm, 0.7 m +- 150 mm.
  const auto bound = [](double sigma_m) {
    const double bound_mm = 1000 * z_95 * sigma_m;
    return fmt::format("+- {:.{}f} mm", bound_mm, bound_mm < 9.95 ? 1 : 0);
  };
  const int decimals = static_cast<int>(std::clamp(std::ceil(-std::log10(z_95 * along_m)), 1.0, 4.0));
  return fmt::format("{:.{}f} m {}, across {}", position.p_C.norm(), decimals, bound(along_m),
                     bound(across_m));
}

}  // namespace ballservo
