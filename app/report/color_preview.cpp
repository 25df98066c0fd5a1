#include "app/report/color_preview.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <opencv2/imgproc.hpp>

#include "app/report/overlay.hpp"
#include "app/report/picture.hpp"
#include "calibration/teaching/chroma_picture.hpp"

namespace ballservo {
namespace {

constexpr int side = ChromaHistogram::side;
constexpr int plane_px = 640;
constexpr float plane_lightness = 70;
constexpr double label_size = 0.6;

/// The (a, b) plane of Lab at one lightness, b upwards, as far from grey as `reach`.
cv::Mat3f lab_plane(int size_px, float lightness, double reach) {
  cv::Mat3f lab(size_px, size_px);
  const double middle = size_px / 2;
  for (int y = 0; y < size_px; ++y) {
    for (int x = 0; x < size_px; ++x)
      lab(y, x) = {lightness, static_cast<float>((x + 0.5 - middle) * reach / middle),
                   static_cast<float>((middle - y - 0.5) * reach / middle)};
  }
  return lab;
}

/// The part of the (a, b) plane that is drawn: a square around grey, large enough for every cell that is
/// `used`.
class ChromaPlane {
 public:
  explicit ChromaPlane(const cv::Mat1b& used) {
    double farthest = 20;
    if (const cv::Rect box = cv::boundingRect(used); !box.empty()) {
      for (const int end : {box.x, box.y, box.br().x - 1, box.br().y - 1})
        farthest = std::max(farthest, std::abs(2.0 * end + 1 - side));
    }
    reach_ = std::min(128.0, std::ceil((farthest + 4) / 10) * 10);
    const cv::Mat3f lab = lab_plane(plane_px, plane_lightness, reach_);
    cv::cvtColor(lab, colors_, cv::COLOR_Lab2BGR);
    cells_.create(lab.size());
    std::transform(lab.begin(), lab.end(), cells_.begin(), [](const cv::Vec3f& color) {
      const int cell = chroma_cell(color[1], color[2]);
      return cv::Vec2s(static_cast<short>(cell % side), static_cast<short>(cell / side));
    });
  }

  cv::Point point(double a, double b) const {
    return {static_cast<int>(std::lround((a / reach_ + 1) * (plane_px / 2))),
            static_cast<int>(std::lround((1 - b / reach_) * (plane_px / 2)))};
  }

  /// What cells hold, at every pixel.
  cv::Mat spread(const cv::Mat& by_cell) const {
    cv::Mat by_pixel;
    cv::remap(by_cell, by_pixel, cells_, {}, cv::INTER_NEAREST);
    return by_pixel;
  }

  /// The plane in its own colours, dimmed to a `brightness` (0 to 1) by cell, with its axes.
  cv::Mat drawn(const cv::Mat1f& brightness) const {
    cv::Mat share, picture;
    cv::merge(std::vector<cv::Mat>(3, spread(brightness)), share);
    const cv::Mat paper(colors_.size(), CV_32FC3, cv::Scalar(0.11, 0.10, 0.10));
    cv::Mat(paper.mul(cv::Scalar::all(1) - share) + colors_.mul(share)).convertTo(picture, CV_8U, 255);
    draw_axes(picture);
    return picture;
  }

 private:
  /// Axes, and rings of equal chroma with their values.
  void draw_axes(cv::Mat& picture) const {
    const cv::Scalar line(95, 95, 95), text(190, 190, 190);
    const cv::Point middle = point(0, 0);
    cv::line(picture, {0, middle.y}, {plane_px - 1, middle.y}, line, 1);
    cv::line(picture, {middle.x, 0}, {middle.x, plane_px - 1}, line, 1);
    const double step = reach_ > 60 ? 25 : reach_ > 30 ? 10 : 5;
    for (double chroma = step; chroma < reach_; chroma += step) {
      cv::circle(picture, middle, point(chroma, 0).x - middle.x, line, 1, cv::LINE_AA);
      cv::putText(picture, fmt::format("{}", chroma), point(chroma, 0) + cv::Point(3, -4),
                  cv::FONT_HERSHEY_SIMPLEX, 0.4, text, 1, cv::LINE_AA);
    }
    cv::putText(picture, "a", {plane_px - 18, middle.y + 18}, cv::FONT_HERSHEY_SIMPLEX, 0.55, text, 1,
                cv::LINE_AA);
    cv::putText(picture, "b", {middle.x + 8, 16}, cv::FONT_HERSHEY_SIMPLEX, 0.55, text, 1, cv::LINE_AA);
  }

  double reach_ = 128;
  cv::Mat3f colors_;  // of every pixel
  cv::Mat2s cells_;   // of the histogram, under every pixel
};

cv::Mat groups_picture(const ColorTable& colors, const std::vector<ChromaGroup>& groups,
                       const ChromaPlane& plane) {
  cv::Mat1f brightness = cv::Mat1f::zeros(side, side);
  for (const ChromaGroup& group : groups) brightness.setTo(0.5, group.cells);
  for (const ChromaGroup& group : groups) brightness.setTo(1, group.core);
  cv::Mat picture = plane.drawn(brightness);
  std::vector<cv::Rect> labels;
  for (std::size_t k = 0; k < groups.size(); ++k) {
    std::vector<std::vector<cv::Point>> outlines;
    cv::findContours(plane.spread(groups[k].cells), outlines, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_NONE);
    cv::drawContours(picture, outlines, -1, {255, 255, 255}, 1, cv::LINE_AA);
    const cv::Moments moments = cv::moments(groups[k].core, true);
    if (moments.m00 <= 0) continue;
    const cv::Point at = plane.point(2 * (moments.m10 / moments.m00 + 0.5) - side,
                                     2 * (moments.m01 / moments.m00 + 0.5) - side);
    draw_text_apart(picture, colors.classes[k].name, at, label_size, labels);
  }
  return picture;
}

cv::Mat segments_picture(const LearntColors& colors, std::size_t index, cv::Size size) {
  const cv::Mat modes = smoothed_chroma(chroma_image(colors.pictures[index].bgr));
  cv::Mat luv, bgr, picture;
  cv::merge(std::vector<cv::Mat>{cv::Mat(modes.size(), CV_32F, plane_lightness), modes}, luv);
  cv::cvtColor(luv, bgr, cv::COLOR_Luv2BGR);
  bgr.convertTo(picture, CV_8U, 255);
  if (picture.size() != size) cv::resize(picture, picture, size, 0, 0, cv::INTER_NEAREST);
  return picture;
}

/// The circles that were accepted, drawn into a picture.
cv::Mat with_circles(cv::Mat picture, const LearntColors& colors, std::size_t index) {
  const int thickness = std::max(1, picture.cols / 500);
  for (const auto& [name, circles] : colors.circles) {
    for (const LearntCircle& circle : circles) {
      if (circle.picture != index) continue;
      draw_circle(picture, circle.center_px, circle.radius_px, {0, 0, 0}, thickness + 2);
      draw_circle(picture, circle.center_px, circle.radius_px, {255, 255, 255}, thickness);
    }
  }
  return picture;
}

cv::Mat classes_picture(const ColorTable& colors, const cv::Mat& bgr) {
  std::vector<cv::Vec3b> shown(colors.classes.size() + 1);
  for (std::size_t k = 1; k < shown.size(); ++k) {
    const cv::Scalar color = class_display_color(colors, static_cast<ClassIndex>(k));
    const double brightest = std::max({color[0], color[1], color[2], 1.0});
    for (int channel = 0; channel < 3; ++channel) {
      shown[k][channel] = cv::saturate_cast<std::uint8_t>(color[channel] * 240 / brightest);
    }
  }
  cv::Mat grey, picture;
  cv::cvtColor(bgr, grey, cv::COLOR_BGR2GRAY);
  cv::cvtColor(grey * 0.35 + 10, picture, cv::COLOR_GRAY2BGR);
  for (int y = 0; y < bgr.rows; ++y) {
    for (int x = 0; x < bgr.cols; ++x) {
      const cv::Vec3b& c = bgr.at<cv::Vec3b>(y, x);
      const ClassIndex index = colors.classify(c[0], c[1], c[2]);
      if (index != no_class) picture.at<cv::Vec3b>(y, x) = shown[index];
    }
  }
  return picture;
}

/// The table itself: (a, b) planes at six lightnesses, what is of a class in its colour, the rest dimmed, and
/// what no screen can show left out.
cv::Mat table_picture(const ColorTable& colors) {
  constexpr int tile = 220, columns = 3;
  const std::vector<float> lightnesses = {20, 35, 50, 65, 80, 92};
  cv::Mat3b picture(tile * (static_cast<int>(lightnesses.size()) / columns), tile * columns,
                    cv::Vec3b(28, 26, 26));
  for (std::size_t k = 0; k < lightnesses.size(); ++k) {
    const cv::Mat3f lab = lab_plane(tile, lightnesses[k], 110);
    cv::Mat3f bgr, back;
    cv::cvtColor(lab, bgr, cv::COLOR_Lab2BGR);
    cv::cvtColor(bgr, back, cv::COLOR_BGR2Lab);
    cv::Mat3b part = picture(
        cv::Rect(static_cast<int>(k) % columns * tile, static_cast<int>(k) / columns * tile, tile, tile));
    for (int y = 0; y < tile; ++y) {
      for (int x = 0; x < tile; ++x) {
        if (cv::norm(back(y, x) - lab(y, x)) > 1) continue;  // no colour of sRGB
        const cv::Vec3b color = 255 * bgr(y, x);
        const bool known = colors.classify(color[0], color[1], color[2]) != no_class;
        part(y, x) = known ? color : cv::Vec3b(color / 4);
      }
    }
    draw_text(picture, fmt::format("L {:.0f}", lightnesses[k]),
              {static_cast<int>(k) % columns * tile + 6, static_cast<int>(k) / columns * tile + 16}, 0.45);
  }
  return picture;
}

std::vector<PreviewPanel> chroma_panels(const ColorTable& colors, const std::vector<ChromaGroup>& groups) {
  cv::Mat1d counts = cv::Mat1d::zeros(side, side);
  for (const ColorClass& color : colors.classes)
    std::transform(counts.begin(), counts.end(), color.histogram.counts.begin(), counts.begin(),
                   std::plus<>());
  cv::Mat1b used = counts > 0;
  for (const ChromaGroup& group : groups) used |= group.cells;
  const ChromaPlane plane(used);
  double most = 0;
  cv::minMaxLoc(counts, nullptr, &most);
  cv::Mat1d logs;
  cv::log(counts + 1, logs);
  cv::Mat1f brightness = 0.25 + 0.75 / std::log1p(most) * logs;
  brightness.setTo(0, counts == 0);
  return {{"c_chroma", "(c) chroma of the samples", plane.drawn(brightness)},
          {"d_groups", "(d) colour groups after closing", groups_picture(colors, groups, plane)}};
}

/// The panels with the table's own, and before its last that of the pixels' classes.
std::vector<PreviewPanel> with_table(std::vector<PreviewPanel> panels, const ColorTable& colors,
                                     const cv::Mat& bgr) {
  for (PreviewPanel& panel : color_preview(colors)) panels.push_back(std::move(panel));
  panels.insert(panels.end() - 1, {"e_classes", "(e) class of every pixel", classes_picture(colors, bgr)});
  return panels;
}

}  // namespace

std::vector<PreviewPanel> color_preview(const LearntColors& colors, const std::vector<ColorPicture>& pictures,
                                        std::size_t picture) {
  const cv::Mat& bgr = pictures.at(picture).bgr;
  return with_table({{"a_source", "(a) circles accepted: " + pictures[picture].source,
                      with_circles(bgr.clone(), colors, picture)},
                     {"b_segments", "(b) chroma, circles accepted",
                      with_circles(segments_picture(colors, picture, bgr.size()), colors, picture)}},
                    colors.table, bgr);
}

std::vector<PreviewPanel> box_preview(const ColorTable& colors, const BoxTrainer::Shown& shown) {
  cv::Mat picture = shown.bgr.clone();
  const int thickness = std::max(1, picture.cols / 500);
  const auto at = [](const Eigen::Vector2d& p) { return cv::Point(cvRound(p.x()), cvRound(p.y())); };
  const Eigen::Vector2d half = Eigen::Vector2d::Constant(shown.box.radius_px);
  for (const auto& [color, width] : {std::make_pair(0, thickness + 2), std::make_pair(255, thickness)}) {
    cv::rectangle(picture, at(shown.box.center_px - half), at(shown.box.center_px + half),
                  cv::Scalar::all(color), width, cv::LINE_AA);
    cv::circle(picture, at(shown.ball.center_px), cvRound(shown.ball.radius_px), cv::Scalar::all(color),
               width, cv::LINE_AA);
  }
  return with_table(
      {{"a_source", fmt::format("(a) frame {}: the box, and the ball found in it", shown.frame), picture}},
      colors, shown.bgr);
}

std::vector<PreviewPanel> color_preview(const ColorTable& colors) {
  std::vector<ChromaGroup> groups;
  for (const ColorClass& color : colors.classes) groups.push_back(chroma_group(color.histogram));
  std::vector<PreviewPanel> panels = chroma_panels(colors, groups);
  panels.push_back({"f_table", "(f) the table: class by lightness", table_picture(colors)});
  return panels;
}

cv::Mat preview_figure(const std::vector<PreviewPanel>& panels) {
  constexpr double panel_height = 440, panel_width = 600;
  std::vector<std::pair<std::string, cv::Mat>> named;
  for (const PreviewPanel& panel : panels) {
    const double scale = std::min(panel_width / panel.picture.cols, panel_height / panel.picture.rows);
    cv::Mat fitted;
    cv::resize(panel.picture, fitted, {}, scale, scale, scale < 1 ? cv::INTER_AREA : cv::INTER_LINEAR);
    named.emplace_back(panel.caption, fitted);
  }
  return labelled_grid(named);
}

}  // namespace ballservo
