#include "app/live/color_lessons.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "app/report/overlay.hpp"
#include "calibration/base/fault.hpp"
#include "calibration/color/color_file.hpp"
#include "calibration/color/color_names.hpp"
#include "calibration/teaching/class_report.hpp"
#include "calibration/teaching/class_table.hpp"
#include "calibration/teaching/clear_picture.hpp"
#include "calibration/teaching/color_samples.hpp"
#include "calibration/teaching/merge_colors.hpp"

namespace ballservo {
namespace {

constexpr std::size_t most_lessons = max_classes;  // learnt from together

void check_name(const std::string& name) {
  if (!is_class_name(name)) throw InputError("name", "'" + name + "'", class_name_rule);
}

/// The likeliest ball that the picture's edges propose around the point.
PointedBall ball_around(const RoundRegions& found, const Eigen::Vector2d& point) {
  for (const RoundRegion& region : found.regions) {
    if ((region.center_px - point).norm() <= region.radius_px) return {region.center_px, region.radius_px};
  }
  throw Refusal(
      "nothing round is seen there. Show the ball whole, in even light; or press on its middle and draw to "
      "its rim");
}

/// What is inside the circle as a class, named by its colour's word.
ColorTable class_inside(const cv::Mat& bgr, const PointedBall& ball) {
  RoundRegion disc;
  disc.center_px = ball.center_px;
  disc.radius_px = ball.radius_px;
  const ColorSamples samples = samples_inside(bgr, disc, 1);
  if (samples.pixels.size() < 10 || samples.colored_fraction() < 0.1)
    throw Refusal("hardly a pixel there has a colour: black, white and grey things can't be learnt");
  ColorTable table;
  table.classes.push_back({color_word(samples.mean_lab()), samples.pixels.size(), {}, samples.cells()});
  return table;
}

/// Of the joint table the class `k` alone, under another name and without any background.
ColorTable single_class(const ColorTable& joint, std::size_t k, const std::string& name) {
  ColorTable table;
  table.classes = {joint.classes[k]};
  table.classes.front().name = name;
  rebuild(table);
  return table;
}

/// As the page lists them: see README.md.
nlohmann::json classes_json(const ColorTable& table, const std::vector<ClassReport>& reports) {
  nlohmann::json listed = nlohmann::json::array();
  for (std::size_t k = 0; k < table.classes.size(); ++k) {
    const ClassReport& report = reports[k];
    const cv::Scalar color = class_display_color(table, static_cast<ClassIndex>(k + 1));
    nlohmann::json overlap = nlohmann::json::object();
    for (const auto& [other, fraction] : report.overlap) {
      if (fraction >= 0.01) overlap[other] = fraction;
    }
    listed.push_back({{"name", table.classes[k].name},
                      {"color", fmt::format("#{:02x}{:02x}{:02x}", static_cast<int>(color[2]),
                                            static_cast<int>(color[1]), static_cast<int>(color[0]))},
                      {"samples", table.classes[k].samples},
                      {"kept_fraction", report.kept_fraction},
                      {"background_fraction", report.background_fraction},
                      {"overlap", overlap},
                      {"level_low", report.light.level_low},
                      {"level_high", report.light.level_high},
                      {"warmest_k", report.light.warmest_k},
                      {"coolest_k", report.light.coolest_k}});
  }
  return listed;
}

}  // namespace

ColorLessons::ColorLessons(ColorTable table)
    : base_(std::make_shared<ColorTable>(std::move(table))), table_(base_) {
  const std::vector<ClassReport> reports = report_classes(*table_);
  classes_ = classes_json(*table_, reports);
  warnings_ = judge_classes(*table_, reports).warnings;
}

ColorLessons ColorLessons::with(PointedLesson lesson, const std::function<void()>& between,
                                const std::function<void(const PointedBall&)>& found,
                                std::string& name) const {
  if (lessons_.size() >= most_lessons)
    throw Refusal(fmt::format("{} lessons are remembered already: save the colours, and load them to go on",
                              most_lessons));
  if (!lesson.name.empty()) check_name(lesson.name);
  const cv::Rect2d picture(-0.5, -0.5, lesson.bgr.cols, lesson.bgr.rows);
  const PointedBall& at = lesson.at;
  if (!picture.contains({at.center_px.x(), at.center_px.y()}))
    throw InputError("place", "outside the picture", "a place in it");
  for (const PointedLesson& earlier : lessons_) {
    if (earlier.bgr.data == lesson.bgr.data) lesson.searched = earlier.searched;
  }
  if (!lesson.searched) {
    RegionSearchOptions search;
    search.before_each_test = between;
    lesson.searched =
        std::make_shared<const RoundRegions>(find_round_regions(clear_picture(lesson.bgr), search));
  }
  if (!(lesson.at.radius_px >= 2)) lesson.at = ball_around(*lesson.searched, lesson.at.center_px);
  found(lesson.at);
  const ColorTable inside = class_inside(lesson.bgr, lesson.at);
  if (lesson.name.empty()) lesson.name = names_to_join(inside, *table_).front();
  name = lesson.name;
  ColorLessons result = *this;
  result.lessons_.push_back(std::move(lesson));
  result.learn();
  return result;
}

ColorLessons ColorLessons::renamed(const std::string& from, const std::string& to) const {
  check_name(to);
  if (!table_->find(from)) throw InputError("class", "'" + from + "'", "a class that there is");
  ColorLessons result = *this;
  for (PointedLesson& lesson : result.lessons_) {
    if (lesson.name == from) lesson.name = to;
  }
  std::vector<ColorTable> tables;
  for (std::size_t k = 0; k < base_->classes.size(); ++k) {
    const std::string& name = base_->classes[k].name;
    tables.push_back(single_class(*base_, k, name == from ? to : name));
  }
  if (!tables.empty()) {
    tables.front().background = base_->background;
    ColorTable base = merge_colors(tables);
    base.camera_settings = base_->camera_settings;
    result.base_ = std::make_shared<ColorTable>(std::move(base));
  }
  result.learn();
  return result;
}

void ColorLessons::learn() {
  std::vector<ColorTable> tables;
  if (!base_->classes.empty()) tables.push_back(*base_);
  if (!lessons_.empty()) {
    std::vector<ColorPicture> pictures;
    std::vector<ClassRequest> requests;
    for (const PointedLesson& lesson : lessons_) {
      const auto known = std::find_if(pictures.begin(), pictures.end(), [&](const ColorPicture& picture) {
        return picture.bgr.data == lesson.bgr.data;
      });
      const auto place = static_cast<std::size_t>(known - pictures.begin());
      if (known == pictures.end())
        pictures.push_back({fmt::format("picture {}", pictures.size() + 1), lesson.bgr, lesson.searched});
      requests.push_back({fmt::format("lesson{}", requests.size()), {place}, lesson.at});
    }
    LearntColors joint = learn_classes(pictures, requests);
    if (tables.empty() && lessons_.size() == 1) {  // nothing to merge
      joint.table.classes.front().name = lessons_.front().name;
      return use(std::make_shared<const ColorTable>(std::move(joint.table)));
    }
    for (std::size_t k = 0; k < lessons_.size(); ++k)
      tables.push_back(single_class(joint.table, k, lessons_[k].name));
    tables.back().background = joint.table.background;
  }
  use(std::make_shared<const ColorTable>(tables.empty() ? ColorTable() : merge_colors(tables)));
}

void ColorLessons::use(std::shared_ptr<const ColorTable> table) {
  table_ = std::move(table);
  const std::vector<ClassReport> reports = report_classes(*table_);
  classes_ = classes_json(*table_, reports);
  ClassFindings findings = judge_classes(*table_, reports);
  if (!findings.refusals.empty()) throw Refusal(findings.refusals.front());
  warnings_ = std::move(findings.warnings);
}

}  // namespace ballservo
