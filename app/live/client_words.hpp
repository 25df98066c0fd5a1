// What clients say, and what is said to them.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "app/live/live_exchange.hpp"
#include "calibration/base/fault.hpp"

namespace ballservo {

/// A message: an object that says what is to be done (`do`), and does not nest deeply. Nothing for any other
/// text.
std::optional<nlohmann::json> message_of(const std::string& text);

double number_at(const nlohmann::json& what, const char* key, double otherwise);
/// A length that the page takes in millimetres; throws Refusal, in millimetres, for one outside the range.
double length_m_at(const nlohmann::json& what, const char* key, const char* name, double least_m,
                   double most_m);
/// Empty where there is none.
std::string text_at(const nlohmann::json& what, const char* key);

/// Points of a picture, to a tenth of a pixel.
nlohmann::json points_px_json(const std::vector<Eigen::Vector2d>& points_px);

/// Bytes in JSON (RFC 4648), and what they were; nothing for a text that is none.
std::string base64(const std::string& bytes);
std::optional<std::string> from_base64(const std::string& text);
/// A file that the browser is to save.
nlohmann::json download_json(const std::string& name, const std::string& bytes);

/// All faults in a line.
std::string words_of(const InputError& error);

/// Answers a command: with what `done` gives, or why it is refused. Null: the answer comes later.
void answer(const LiveCommand& command, const std::function<nlohmann::json()>& done);

}  // namespace ballservo
