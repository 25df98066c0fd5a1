#include "app/comparison/comparison_archive.hpp"

#include "calibration/base/fault.hpp"

namespace ballservo {
namespace {

using nlohmann::json;

[[noreturn]] void damaged(const std::string& place) {
  throw InputError(place, "not what `compare` writes", "the folder of a finished part, as it was written");
}

}  // namespace

std::string comparison_setting_text(const std::vector<ConditionInfo>& conditions, const MethodList& methods,
                                    std::uint64_t seed, const ComparisonReportText& text) {
  json list = json::array(), names = json::array();
  for (const ConditionInfo& info : conditions) {
    list.push_back({{"name", info.name},
                    {"words", info.words},
                    {"frames", info.frames},
                    {"swept_key", info.swept_key},
                    {"swept_label", info.swept_label},
                    {"swept_value", info.swept_value},
                    {"swept_log", info.swept_log}});
  }
  for (const FitMethod* method : methods) names.push_back(method->name);
  const json all = {{"conditions", list},          {"methods", names},        {"seed", seed},
                    {"subject", text.subject},     {"setting", text.setting}, {"rendered", text.rendered},
                    {"claims", text.claims_wanted}};
  return all.dump(1, ' ', false, json::error_handler_t::replace) + "\n";
}

ComparisonSetting read_comparison_setting(const std::string& text, const std::string& place) {
  ComparisonSetting setting;
  try {
    const json all = json::parse(text);
    for (const json& item : all.at("conditions")) {
      ConditionInfo info;
      info.name = item.at("name").get<std::string>();
      info.words = item.at("words").get<std::string>();
      info.frames = item.at("frames").get<int>();
      info.swept_key = item.at("swept_key").get<std::string>();
      info.swept_label = item.at("swept_label").get<std::string>();
      info.swept_value = item.at("swept_value").is_null() ? 0 : item.at("swept_value").get<double>();
      info.swept_log = item.at("swept_log").get<bool>();
      setting.conditions.push_back(info);
    }
    for (const json& name : all.at("methods")) {
      const FitMethod* method = find_fit_method(name.get<std::string>());
      if (!method) damaged(place);
      setting.methods.push_back(method);
    }
    setting.seed = all.at("seed").get<std::uint64_t>();
    setting.text.subject = all.at("subject").get<std::string>();
    setting.text.setting = all.at("setting").get<std::string>();
    setting.text.rendered = all.at("rendered").get<bool>();
    setting.text.claims_wanted = all.at("claims").get<bool>();
  } catch (const json::exception&) {
    damaged(place);
  }
  return setting;
}

}  // namespace ballservo
