#include "app/comparison/comparison_archive.hpp"

#include <nlohmann/json.hpp>

#include "calibration/base/fault.hpp"

namespace ballservo {

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(ConditionInfo, name, words, frames, swept_key, swept_label, swept_value,
                                   swept_log)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(ComparisonReportText, subject, setting, rendered, claims_wanted)

std::string comparison_setting_text(const ComparisonSetting& setting) {
  nlohmann::json names = nlohmann::json::array();
  for (const FitMethod* method : setting.methods) names.push_back(method->name);
  const nlohmann::json all = {
      {"conditions", setting.conditions}, {"methods", names}, {"seed", setting.seed}, {"text", setting.text}};
  return all.dump(1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

ComparisonSetting read_comparison_setting(const std::string& text, const std::string& place) {
  ComparisonSetting setting;
  bool known = true;
  try {
    const nlohmann::json all = nlohmann::json::parse(text);
    all.at("conditions").get_to(setting.conditions);
    all.at("seed").get_to(setting.seed);
    all.at("text").get_to(setting.text);
    for (const std::string name : all.at("methods")) {
      setting.methods.push_back(find_fit_method(name));
      known = known && setting.methods.back() != nullptr;
    }
  } catch (const nlohmann::json::exception&) {
    known = false;
  }
  if (!known)
    throw InputError(place, "not what `compare` writes", "the folder of a finished part, as it was written");
  return setting;
}

}  // namespace ballservo
