#include "app/report/color_preview.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
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

/// The part of the (a, b) plane that is drawn: a square around grey, large enough for every sample.
class ChromaPlane {
 public:
  explicit ChromaPlane(const std::vector<cv::Mat1b>& used) {
    double farthest = 20;
    for (const cv::Mat1b& cells : used) {
      for (int i = 0; i < side * side; ++i) {
        if (!cells(i / side, i % side)) continue;
        farthest = std::max(
            {farthest, std::abs(2.0 * (i % side) + 1 - side), std::abs(2.0 * (i / side) + 1 - side)});
      }
    }
    reach_ = std::min(128.0, std::ceil((farthest + 4) / 10) * 10);
  }

  double a_at(int x) const { return (x + 0.5 - plane_px / 2) * reach_ / (plane_px / 2); }
  double b_at(int y) const { return (plane_px / 2 - y - 0.5) * reach_ / (plane_px / 2); }
  cv::Point point(double a, double b) const {
    return {static_cast<int>(std::lround((a / reach_ + 1) * (plane_px / 2))),
            static_cast<int>(std::lround((1 - b / reach_) * (plane_px / 2)))};
  }
  /// The histogram cell under a pixel.
  cv::Point cell(int x, int y) const {
    const int cell = chroma_cell(a_at(x), b_at(y));
    return {cell % side, cell / side};
  }

  /// The plane in its own colours, dimmed, and at `brightness` (0 to 1, by pixel).
  template <class Brightness>
  cv::Mat drawn(Brightness brightness) const {
    cv::Mat3f lab(plane_px, plane_px);
    for (int y = 0; y < plane_px; ++y) {
      for (int x = 0; x < plane_px; ++x) {
        lab(y, x) = {plane_lightness, static_cast<float>(a_at(x)), static_cast<float>(b_at(y))};
      }
    }
    cv::Mat3f bgr;
    cv::cvtColor(lab, bgr, cv::COLOR_Lab2BGR);
    cv::Mat3b result(plane_px, plane_px);
    const cv::Vec3f paper(0.11f, 0.10f, 0.10f);
    for (int y = 0; y < plane_px; ++y) {
      for (int x = 0; x < plane_px; ++x) {
        const auto share = static_cast<float>(brightness(cell(x, y)));
        const cv::Vec3f color = paper * (1 - share) + bgr(y, x) * share;
        for (int k = 0; k < 3; ++k) result(y, x)[k] = cv::saturate_cast<std::uint8_t>(255 * color[k]);
      }
    }
    return result;
  }

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

 private:
  double reach_ = 128;
};

/// Text that can be read on anything.
void put_label(cv::Mat& picture, const std::string& text, cv::Point at, double size) {
  cv::putText(picture, text, at, cv::FONT_HERSHEY_SIMPLEX, size, {0, 0, 0}, 3, cv::LINE_AA);
  cv::putText(picture, text, at, cv::FONT_HERSHEY_SIMPLEX, size, {255, 255, 255}, 1, cv::LINE_AA);
}

/// Where a label about `at` covers none of the others: the nearest such place above or below.
cv::Rect free_place(cv::Point at, const std::string& text, const std::vector<cv::Rect>& others) {
  const cv::Size size =
      cv::getTextSize(text, cv::FONT_HERSHEY_SIMPLEX, label_size, 1, nullptr) + cv::Size(4, 10);
  const int left = std::clamp(at.x - size.width / 2, 0, std::max(0, plane_px - size.width));
  for (int step = 0; step < plane_px; ++step) {
    for (const int sign : {1, -1}) {
      const cv::Rect place({left, at.y - size.height / 2 + sign * step}, size);
      const bool inside = place.y >= 0 && place.br().y <= plane_px;
      if (inside && std::none_of(others.begin(), others.end(),
                                 [&](const cv::Rect& other) { return (other & place).area() > 0; }))
        return place;
    }
  }
  return {{left, at.y - size.height / 2}, size};
}

cv::Mat chroma_distribution(const ColorTable& colors, const ChromaPlane& plane) {
  cv::Mat1d counts = cv::Mat1d::zeros(side, side);
  for (const ColorClass& color : colors.classes) {
    for (int i = 0; i < side * side; ++i) counts(i / side, i % side) += color.histogram.counts[i];
  }
  double most = 0;
  cv::minMaxLoc(counts, nullptr, &most);
  cv::Mat picture = plane.drawn([&](const cv::Point& cell) {
    if (counts(cell) <= 0) return 0.0;
    return 0.25 + 0.75 * std::log1p(counts(cell)) / std::log1p(most);
  });
  plane.draw_axes(picture);
  return picture;
}

cv::Mat groups_picture(const ColorTable& colors, const std::vector<ChromaGroup>& groups,
                       const ChromaPlane& plane) {
  cv::Mat picture = plane.drawn([&](const cv::Point& cell) {
    double share = 0;
    for (const ChromaGroup& group : groups) {
      if (group.core(cell)) return 1.0;
      if (group.cells(cell)) share = 0.5;
    }
    return share;
  });
  plane.draw_axes(picture);
  std::vector<cv::Rect> labels;
  for (std::size_t k = 0; k < groups.size(); ++k) {
    cv::Mat1b shape(plane_px, plane_px);
    for (int y = 0; y < plane_px; ++y) {
      for (int x = 0; x < plane_px; ++x) shape(y, x) = groups[k].cells(plane.cell(x, y));
    }
    std::vector<std::vector<cv::Point>> outlines;
    cv::findContours(shape, outlines, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_NONE);
    cv::drawContours(picture, outlines, -1, {255, 255, 255}, 1, cv::LINE_AA);
    const cv::Moments moments = cv::moments(groups[k].core, true);
    if (moments.m00 <= 0) continue;
    const cv::Point at = plane.point(2 * (moments.m10 / moments.m00 + 0.5) - side,
                                     2 * (moments.m01 / moments.m00 + 0.5) - side);
    labels.push_back(free_place(at, colors.classes[k].name, labels));
    put_label(picture, colors.classes[k].name, {labels.back().x, labels.back().br().y - 4}, label_size);
  }
  return picture;
}

cv::Mat segments_picture(const LearntColors& colors, std::size_t index, cv::Size size) {
  const cv::Mat modes = smoothed_chroma(chroma_image(colors.pictures[index].bgr));
  cv::Mat3f luv(modes.size());
  for (int y = 0; y < modes.rows; ++y) {
    for (int x = 0; x < modes.cols; ++x) {
      const cv::Vec2f& c = modes.at<cv::Vec2f>(y, x);
      luv(y, x) = {plane_lightness, c[0], c[1]};
    }
  }
  cv::Mat bgr, picture;
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
      constexpr int bits = 4;
      const cv::Point center(cvRound(circle.center_px.x() * (1 << bits)),
                             cvRound(circle.center_px.y() * (1 << bits)));
      const int radius = cvRound(circle.radius_px * (1 << bits));
      cv::circle(picture, center, radius, {0, 0, 0}, thickness + 2, cv::LINE_AA, bits);
      cv::circle(picture, center, radius, {255, 255, 255}, thickness, cv::LINE_AA, bits);
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
    cv::Mat3f lab(tile, tile), bgr;
    for (int y = 0; y < tile; ++y) {
      for (int x = 0; x < tile; ++x)
        lab(y, x) = {lightnesses[k], (x + 0.5f - tile / 2) * 220 / tile, (tile / 2 - y - 0.5f) * 220 / tile};
    }
    cv::cvtColor(lab, bgr, cv::COLOR_Lab2BGR);
    cv::Mat3f back;
    cv::cvtColor(bgr, back, cv::COLOR_BGR2Lab);
    cv::Mat3b part = picture(
        cv::Rect(static_cast<int>(k) % columns * tile, static_cast<int>(k) / columns * tile, tile, tile));
    for (int y = 0; y < tile; ++y) {
      for (int x = 0; x < tile; ++x) {
        if (cv::norm(back(y, x) - lab(y, x)) > 1) continue;  // no colour of sRGB
        const cv::Vec3b color(cv::saturate_cast<std::uint8_t>(255 * bgr(y, x)[0]),
                              cv::saturate_cast<std::uint8_t>(255 * bgr(y, x)[1]),
                              cv::saturate_cast<std::uint8_t>(255 * bgr(y, x)[2]));
        const bool known = colors.classify(color[0], color[1], color[2]) != no_class;
        part(y, x) = known ? color : cv::Vec3b(color / 4);
      }
    }
    put_label(picture, fmt::format("L {:.0f}", lightnesses[k]),
              {static_cast<int>(k) % columns * tile + 6, static_cast<int>(k) / columns * tile + 16}, 0.45);
  }
  return picture;
}

std::vector<PreviewPanel> chroma_panels(const ColorTable& colors, const std::vector<ChromaGroup>& groups) {
  std::vector<cv::Mat1b> used;
  for (std::size_t k = 0; k < groups.size(); ++k) {
    used.push_back(groups[k].cells);
    const auto& counts = colors.classes[k].histogram.counts;
    cv::Mat1b occupied(side, side);
    for (int i = 0; i < side * side; ++i) occupied(i / side, i % side) = counts[i] > 0 ? 255 : 0;
    used.push_back(occupied);
  }
  const ChromaPlane plane(used);
  return {{"c_chroma", "(c) chroma of the samples", chroma_distribution(colors, plane)},
          {"d_groups", "(d) colour groups after closing", groups_picture(colors, groups, plane)}};
}

}  // namespace

std::vector<PreviewPanel> color_preview(const LearntColors& colors, const std::vector<ColorPicture>& pictures,
                                        std::size_t picture) {
  const cv::Mat& bgr = pictures.at(picture).bgr;
  std::vector<PreviewPanel> panels = {
      {"a_source", "(a) circles accepted: " + pictures[picture].source,
       with_circles(bgr.clone(), colors, picture)},
      {"b_segments", "(b) chroma, circles accepted",
       with_circles(segments_picture(colors, picture, bgr.size()), colors, picture)}};
  for (PreviewPanel& panel : color_preview(colors.table)) panels.push_back(std::move(panel));
  panels.insert(panels.end() - 1,
                {"e_classes", "(e) class of every pixel", classes_picture(colors.table, bgr)});
  return panels;
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
  std::vector<PreviewPanel> panels = {
      {"a_source", fmt::format("(a) frame {}: the box, and the ball found in it", shown.frame), picture}};
  for (PreviewPanel& panel : color_preview(colors)) panels.push_back(std::move(panel));
  panels.insert(panels.end() - 1,
                {"e_classes", "(e) class of every pixel", classes_picture(colors, shown.bgr)});
  return panels;
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
