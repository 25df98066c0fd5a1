#include "app/live/client_words.hpp"

namespace ballservo {

double number_at(const nlohmann::json& what, const char* key, double otherwise) {
  const auto found = what.find(key);
  return found != what.end() && found->is_number() ? found->get<double>() : otherwise;
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
