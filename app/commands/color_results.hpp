// What `calibrate colors` says of the classes that it learnt, merged or was shown.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "calibration/teaching/class_report.hpp"
#include "calibration/teaching/learn_colors.hpp"

namespace ballservo {

/// The figures of every class; `circles` of those learnt now, with the names of their pictures.
nlohmann::json classes_json(const ColorTable& colors, const std::vector<ClassReport>& reports,
                            const LearntCircles& circles, const std::vector<std::string>& sources);

/// The same in plain words, some lines a class.
std::string classes_text(const ColorTable& colors, const std::vector<ClassReport>& reports,
                         const LearntCircles& circles);

}  // namespace ballservo
