// Colours learnt by pointing at balls in pictures, lesson by lesson, so that each can be taken back.
#pragma once

#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "calibration/color/color_table.hpp"
#include "calibration/teaching/learn_colors.hpp"

namespace ballservo {

/// A ball that somebody points at: its middle or anywhere on it, and its radius, or 0 to have it found.
struct PointedLesson {
  cv::Mat bgr;
  PointedBall at;
  std::string name;  ///< of the class; empty: the one that has this colour, or a new one by its colour's word
  std::shared_ptr<const RoundRegions> searched{};  ///< in the picture, once for all lessons in it
};

/// What is known at one time. Never changed once made.
class ColorLessons {
 public:
  ColorLessons() = default;
  /// What a file holds.
  explicit ColorLessons(ColorTable table);

  const std::shared_ptr<const ColorTable>& table() const { return table_; }
  /// As the page lists them: see README.md.
  const nlohmann::json& classes() const { return classes_; }
  const std::vector<std::string>& warnings() const { return warnings_; }
  bool empty() const { return table_->classes.empty(); }

  /// These, and one more. All lessons are learnt from together, since what is a ball in one is background in
  /// no other; a picture is searched once. `found` hears of the circle before it is learnt from; `name`
  /// becomes its class. `between` is called now and then in the search, and what it throws ends the work.
  /// Throws Refusal where there is no ball or it cannot be learnt, InputError for a name that is none.
  ColorLessons with(PointedLesson lesson, const std::function<void()>& between,
                    const std::function<void(const PointedBall&)>& found, std::string& name) const;
  /// These with a class called otherwise; of the same name as another, both are one. Throws as `with`.
  ColorLessons renamed(const std::string& from, const std::string& to) const;

 private:
  void learn();
  void use(std::shared_ptr<const ColorTable> table);

  std::shared_ptr<const ColorTable> base_ = std::make_shared<ColorTable>();  // that was there before
  std::vector<PointedLesson> lessons_;                                       // each with a name and a radius
  std::shared_ptr<const ColorTable> table_ = base_;                          // all together
  nlohmann::json classes_ = nlohmann::json::array();
  std::vector<std::string> warnings_;
};

}  // namespace ballservo
