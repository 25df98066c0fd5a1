#include "app/commands/color_requests.hpp"

#include <algorithm>

#include "app/commands/command.hpp"
#include "app/io/image_source.hpp"
#include "app/io/interrupt.hpp"
#include "calibration/base/numbers.hpp"
#include "calibration/pictures/image_file.hpp"
#include "calibration/teaching/class_choice.hpp"

namespace ballservo {
namespace {

/// "NAME=REST"; nothing if there is no name or no rest.
std::optional<std::pair<std::string, std::string>> named(const std::string& text) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0 || equals + 1 == text.size()) return std::nullopt;
  return std::make_pair(text.substr(0, equals), text.substr(equals + 1));
}

}  // namespace

std::vector<std::size_t> PictureSet::add(const std::vector<std::string>& sources) {
  std::vector<std::size_t> result;
  constexpr const char* allowed = "image files or folders of images; what moves by --from and --box";
  for (const std::filesystem::path& file : image_files(sources, allowed)) {
    std::error_code ignored;
    const std::filesystem::path unique = std::filesystem::weakly_canonical(file, ignored);
    const auto [known, is_new] = index_.emplace(unique.empty() ? file : unique, files_.size());
    if (is_new) files_.push_back(file);
    if (std::find(result.begin(), result.end(), known->second) == result.end())
      result.push_back(known->second);
  }
  return result;
}

std::optional<std::filesystem::path> PictureSet::shared_with(const PictureSet& other) const {
  for (const auto& [file, index] : index_)
    if (other.index_.count(file) > 0) return files_[index];
  return std::nullopt;
}

std::vector<ColorPicture> PictureSet::read(double max_pixels) const {
  std::vector<ColorPicture> pictures;
  FaultList faults;
  for (const std::filesystem::path& file : files_) {
    throw_if_interrupted();
    faults.collect([&] {
      pictures.push_back({file.filename().string(), read_color_image(file, max_pixels)});
    });
  }
  faults.throw_if_any();
  return pictures;
}

std::vector<ClassRequest> parse_classes(const std::vector<std::string>& texts, PictureSet& pictures,
                                        FaultList& faults) {
  std::vector<ClassRequest> requests;
  for (const std::string& text : texts) {
    const auto parts = named(text);
    if (!parts) {
      faults.add("--class", text, "NAME=IMAGE[,IMAGE...]");
      continue;
    }
    ClassRequest& request = requests.emplace_back();
    request.name = parts->first;
    check_class_name(requests, requests.size() - 1, faults);
    faults.collect([&] { request.pictures = pictures.add(split(parts->second, ',')); });
  }
  return requests;
}

std::optional<std::pair<std::string, PointedBall>> parse_ball(const char* option, const std::string& text,
                                                              FaultList& faults) {
  const auto parts = named(text);
  std::vector<std::optional<double>> numbers;
  if (parts) {
    for (const std::string& number : split(parts->second, ',')) numbers.push_back(parse_number(number));
  }
  if (numbers.size() == 3 && numbers[0] && numbers[1] && numbers[2])
    return std::make_pair(parts->first, PointedBall{{*numbers[0], *numbers[1]}, *numbers[2]});
  faults.add(option, text, "NAME=CX,CY,R with three finite numbers (px)");
  return std::nullopt;
}

void parse_pointed_balls(const std::vector<std::string>& texts, std::vector<ClassRequest>& requests,
                         FaultList& faults) {
  for (const std::string& text : texts) {
    const auto ball = parse_ball("--at", text, faults);
    if (!ball) continue;
    const auto request = std::find_if(requests.begin(), requests.end(),
                                      [&](const ClassRequest& r) { return r.name == ball->first; });
    if (request == requests.end()) {
      faults.add("--at", text, "the name of a --class NAME=IMAGE");
    } else if (request->at) {
      faults.add("--at", ball->first + " twice", "one ball a class");
    } else {
      request->at = ball->second;
    }
  }
}

}  // namespace ballservo
