#include "app/live/client_words.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace ballservo {

std::optional<nlohmann::json> message_of(const std::string& text) {
  constexpr std::ptrdiff_t most_nested =
      64;  // JSON that nests deeply would overflow the stack of who prints it
  if (std::count_if(text.begin(), text.end(), [](char c) { return c == '[' || c == '{'; }) > most_nested)
    return std::nullopt;
  nlohmann::json what = nlohmann::json::parse(text, nullptr, false);
  if (!what.is_object() || text_at(what, "do").empty()) return std::nullopt;
  return what;
}

double number_at(const nlohmann::json& what, const char* key, double otherwise) {
  const auto found = what.find(key);
  return found != what.end() && found->is_number() ? found->get<double>() : otherwise;
}

double length_m_at(const nlohmann::json& what, const char* key, const char* name, double least_m,
                   double most_m) {
  const double length_m = number_at(what, key, std::nan(""));
  if (length_m >= least_m && length_m <= most_m) return length_m;
  throw Refusal(fmt::format("{}: {}; allowed: {:g} to {:g} mm", name,
                            std::isfinite(length_m) ? fmt::format("{:g} mm", 1000 * length_m) : "nothing",
                            1000 * least_m, 1000 * most_m));
}

std::string text_at(const nlohmann::json& what, const char* key) {
  const auto found = what.find(key);
  return found != what.end() && found->is_string() ? found->get<std::string>() : std::string();
}

std::string words_of(const InputError& error) {
  std::string text;
  for (const Fault& fault : error.faults()) text += (text.empty() ? "" : "; ") + to_text(fault);
  return text;
}

nlohmann::json answer_to(const std::string& verb, const std::function<nlohmann::json()>& done) {
  nlohmann::json answer;
  try {
    answer = done();
  } catch (const InputError& error) {
    answer = {{"refused", words_of(error)}};
  } catch (const Refusal& refusal) {
    answer = {{"refused", refusal.what()}};
  }
  answer["answer"] = verb;
  return answer;
}

}  // namespace ballservo
