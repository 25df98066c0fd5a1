#include "app/live/client_words.hpp"

#include <fmt/format.h>
#include <openssl/evp.h>

#include <algorithm>
#include <cmath>
#include <utility>

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

nlohmann::json points_px_json(const std::vector<Eigen::Vector2d>& points_px) {
  nlohmann::json listed = nlohmann::json::array();
  for (const Eigen::Vector2d& p : points_px)
    listed.push_back({std::round(10 * p.x()) / 10, std::round(10 * p.y()) / 10});
  return listed;
}

std::string base64(const std::string& bytes) {
  std::string text(4 * ((bytes.size() + 2) / 3) + 1, '\0');  // with the end that OpenSSL writes
  const int size =
      EVP_EncodeBlock(reinterpret_cast<unsigned char*>(text.data()),
                      reinterpret_cast<const unsigned char*>(bytes.data()), static_cast<int>(bytes.size()));
  text.resize(static_cast<std::size_t>(size));
  return text;
}

std::optional<std::string> from_base64(const std::string& text) {
  std::string bytes(3 * (text.size() / 4) + 3, '\0');
  const int size =
      EVP_DecodeBlock(reinterpret_cast<unsigned char*>(bytes.data()),
                      reinterpret_cast<const unsigned char*>(text.data()), static_cast<int>(text.size()));
  if (size < 0 || text.size() % 4 != 0) return std::nullopt;
  bytes.resize(static_cast<std::size_t>(size));
  for (std::size_t i = 1; i <= 2 && i <= text.size() && text[text.size() - i] == '='; ++i) bytes.pop_back();
  return bytes;
}

nlohmann::json download_json(const std::string& name, const std::string& bytes) {
  return {{"download", name}, {"base64", base64(bytes)}};
}

std::string words_of(const InputError& error) {
  std::string text;
  for (const Fault& fault : error.faults()) text += (text.empty() ? "" : "; ") + to_text(fault);
  return text;
}

void answer(const LiveCommand& command, const std::function<nlohmann::json()>& done) {
  nlohmann::json said;
  try {
    said = done();
    if (said.is_null()) return;
  } catch (const InputError& error) {
    said["refused"] = words_of(error);
  } catch (const std::exception& error) {  // a Refusal, mostly
    said["refused"] = error.what();
  }
  said["answer"] = text_at(command.what, "do");
  command.answer(std::move(said));
}

}  // namespace ballservo
