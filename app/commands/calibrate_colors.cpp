// ballservo calibrate colors: which colours the balls have.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <set>

#include "app/commands/command.hpp"
#include "app/io/image_source.hpp"
#include "app/io/interrupt.hpp"
#include "app/io/progress.hpp"
#include "app/report/color_preview.hpp"
#include "calibration/color/color_file.hpp"
#include "calibration/color/learn_colors.hpp"
#include "calibration/files/fault.hpp"
#include "calibration/files/numbers.hpp"
#include "perception/region_circle.hpp"

namespace ballservo {
namespace {

struct ColorsOptions {
  CommonOptions common;
  std::vector<std::string> sources, classes, at, background;
  std::filesystem::path output, preview, show;
};

std::vector<std::string> split(const std::string& text, char separator) {
  std::vector<std::string> parts;
  std::size_t begin = 0;
  while (true) {
    const std::size_t end = text.find(separator, begin);
    parts.push_back(text.substr(begin, end - begin));
    if (end == std::string::npos) return parts;
    begin = end + 1;
  }
}

/// "NAME=REST"; nothing if there is no name or no rest.
std::optional<std::pair<std::string, std::string>> named(const std::string& text) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0 || equals + 1 == text.size()) return std::nullopt;
  return std::make_pair(text.substr(0, equals), text.substr(equals + 1));
}

/// The pictures of the command line, each read once, however often it is named.
class PictureSet {
 public:
  /// The indices of the pictures that the sources name.
  std::vector<std::size_t> add(const std::vector<std::string>& sources) {
    std::vector<std::size_t> result;
    for (const std::filesystem::path& file : image_files(sources)) {
      std::error_code ignored;
      const std::filesystem::path unique = std::filesystem::weakly_canonical(file, ignored);
      const auto [known, is_new] = index_.emplace(unique.empty() ? file : unique, files_.size());
      if (is_new) files_.push_back(file);
      if (std::find(result.begin(), result.end(), known->second) == result.end())
        result.push_back(known->second);
    }
    return result;
  }

  std::vector<ColorPicture> read(double max_pixels) const {
    std::vector<ColorPicture> pictures;
    FaultList faults;
    for (const std::filesystem::path& file : files_) {
      throw_if_interrupted();
      try {
        pictures.push_back({file.filename().string(), read_color_image(file, max_pixels)});
      } catch (const InputError& error) {
        for (const Fault& fault : error.faults()) faults.add(fault.place, fault.found, fault.allowed);
      }
    }
    faults.throw_if_any();
    return pictures;
  }

 private:
  std::vector<std::filesystem::path> files_;
  std::map<std::filesystem::path, std::size_t> index_;
};

/// Adds another call's faults to a list, so that the user sees all of them at once.
template <class Call>
void collect(FaultList& faults, Call call) {
  try {
    call();
  } catch (const InputError& error) {
    for (const Fault& fault : error.faults()) faults.add(fault.place, fault.found, fault.allowed);
  }
}

std::vector<ClassRequest> parse_classes(const ColorsOptions& options, PictureSet& pictures,
                                        FaultList& faults) {
  std::vector<ClassRequest> requests;
  for (const std::string& text : options.classes) {
    const auto parts = named(text);
    if (!parts) {
      faults.add("--class", text, "NAME=IMAGE[,IMAGE...]");
      continue;
    }
    ClassRequest request;
    request.name = parts->first;
    if (!is_class_name(request.name)) {
      faults.add("--class", "the name \"" + request.name + "\"",
                 "1 to 64 of a-z, 0-9 and _, beginning with a letter");
    }
    for (const ClassRequest& other : requests) {
      if (other.name == request.name) faults.add("--class", request.name + " twice", "each name once");
    }
    collect(faults, [&] { request.pictures = pictures.add(split(parts->second, ',')); });
    requests.push_back(std::move(request));
  }
  return requests;
}

void parse_pointed_balls(const ColorsOptions& options, std::vector<ClassRequest>& requests,
                         FaultList& faults) {
  for (const std::string& text : options.at) {
    const auto parts = named(text);
    std::vector<std::optional<double>> numbers;
    if (parts) {
      for (const std::string& number : split(parts->second, ',')) numbers.push_back(parse_number(number));
    }
    if (numbers.size() != 3 || !numbers[0] || !numbers[1] || !numbers[2]) {
      faults.add("--at", text, "NAME=CX,CY,R with three finite numbers (px)");
      continue;
    }
    const auto request = std::find_if(requests.begin(), requests.end(),
                                      [&](const ClassRequest& r) { return r.name == parts->first; });
    if (request == requests.end()) {
      faults.add("--at", text, "the name of a --class");
    } else if (request->at) {
      faults.add("--at", parts->first + " twice", "one ball a class");
    } else {
      request->at = PointedBall{{*numbers[0], *numbers[1]}, *numbers[2]};
    }
  }
}

nlohmann::json to_json(const LearntColors& colors, const std::vector<ColorPicture>& pictures) {
  nlohmann::json classes = nlohmann::json::object();
  for (std::size_t k = 0; k < colors.classes.size(); ++k) {
    const LearntClass& learnt = colors.classes[k];
    nlohmann::json circles = nlohmann::json::array();
    for (const LearntCircle& circle : learnt.circles) {
      circles.push_back({{"source", pictures[circle.picture].source},
                         {"cx_px", circle.center_px.x()},
                         {"cy_px", circle.center_px.y()},
                         {"r_px", circle.radius_px},
                         {"fit_ratio", circle.fit_ratio}});
    }
    classes[colors.table.classes[k].name] = {{"samples", colors.table.classes[k].samples},
                                             {"circles", circles},
                                             {"kept_fraction", learnt.kept_fraction},
                                             {"overlap", learnt.overlap},
                                             {"background_fraction", learnt.background_fraction}};
  }
  return {{"classes", classes}};
}

void print_summary(const LearntColors& colors) {
  for (std::size_t k = 0; k < colors.classes.size(); ++k) {
    const LearntClass& learnt = colors.classes[k];
    const ColorClass& color = colors.table.classes[k];
    fmt::print("{}: {} ball{}, {} pixels; the table gives {:.1f} % of them back", color.name,
               learnt.circles.size(), learnt.circles.size() == 1 ? "" : "s", color.samples,
               100 * learnt.kept_fraction);
    for (const auto& [other, fraction] : learnt.overlap) {
      if (fraction >= 0.01) fmt::print(", {:.1f} % to {}", 100 * fraction, other);
    }
    fmt::print("; off the balls {:.2f} % of the pixels have this colour\n", 100 * learnt.background_fraction);
  }
}

void write_preview(const OutputFolder& folder, const LearntColors& colors,
                   const std::vector<ColorPicture>& pictures) {
  std::set<std::string> used;
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    throw_if_interrupted();
    const std::string stem = std::filesystem::path(pictures[i].source).stem().string();
    std::string name = stem;
    for (int n = 2; !used.insert(name).second; ++n) name = fmt::format("{}_{}", stem, n);
    const std::vector<PreviewPanel> panels = color_preview(colors, pictures, i);
    for (const PreviewPanel& panel : panels) {
      write_image(folder.path() / fmt::format("{}_{}.png", name, panel.name), panel.picture);
    }
    write_image(folder.path() / fmt::format("{}_figure.png", name), preview_figure(panels));
  }
}

int show_file(const ColorsOptions& options) {
  FaultList faults;
  if (!options.sources.empty()) faults.add("--show", "pictures", "--show FILE with nothing to learn");
  if (!options.classes.empty() || !options.at.empty() || !options.background.empty() ||
      !options.output.empty()) {
    faults.add("--show", "options to learn with", "--show FILE, --preview and --json alone");
  }
  faults.throw_if_any();
  const ColorTable colors = read_color_file(options.show);
  std::optional<OutputFolder> folder;
  if (!options.preview.empty()) folder.emplace(options.preview, options.common.overwrite());
  nlohmann::json classes = nlohmann::json::object();
  for (std::size_t k = 0; k < colors.classes.size(); ++k) {
    const auto cells = std::count(colors.table.begin(), colors.table.end(), static_cast<ClassIndex>(k + 1));
    classes[colors.classes[k].name] = {{"samples", colors.classes[k].samples}, {"table_cells", cells}};
    if (!options.common.quiet) {
      fmt::print("{}: learnt from {} pixels; {} of the table's {} cells\n", colors.classes[k].name,
                 colors.classes[k].samples, cells, ColorTable::entries);
    }
  }
  if (folder) {
    const std::vector<PreviewPanel> panels = color_preview(colors);
    for (const PreviewPanel& panel : panels)
      write_image(folder->path() / (panel.name + ".png"), panel.picture);
    write_image(folder->path() / "figure.png", preview_figure(panels));
    folder->commit();
  }
  write_json_results(options.common, {{"classes", classes}});
  return exit_done;
}

int run_calibrate_colors(const ColorsOptions& options) {
  if (!options.show.empty()) return show_file(options);
  FaultList faults;
  if (options.output.empty()) faults.add("-o", "nothing", "the colours file to write");
  if (options.sources.empty() == options.classes.empty()) {
    faults.add("calibrate colors", options.sources.empty() ? "no picture" : "both pictures and --class",
               "either IMAGE... or --class NAME=IMAGE");
  }
  PictureSet set, off_set;
  collect(faults, [&] {
    if (!options.sources.empty()) set.add(options.sources);
  });
  std::vector<ClassRequest> requests = parse_classes(options, set, faults);
  parse_pointed_balls(options, requests, faults);
  collect(faults, [&] {
    if (!options.background.empty()) off_set.add(options.background);
  });
  faults.throw_if_any();
  OutputFile output(options.output, options.common.overwrite());
  std::optional<OutputFolder> folder;
  if (!options.preview.empty()) folder.emplace(options.preview, options.common.overwrite());

  const std::vector<ColorPicture> pictures = set.read(options.common.max_pixels);
  const std::vector<ColorPicture> background = off_set.read(options.common.max_pixels);
  const CircleEstimator votes = region_circle_estimator(options.common.seed);
  Progress progress("regions tested for roundness", 0, options.common.quiet);
  long asked = 0;
  const CircleEstimator estimator = [&](const std::vector<Eigen::Vector2f>& boundary_px) {
    throw_if_interrupted();
    progress.step(++asked);
    return votes(boundary_px);
  };
  const LearntColors colors = requests.empty() ? learn_colors(pictures, estimator, {}, background)
                                               : learn_classes(pictures, requests, estimator, {}, background);
  if (folder) write_preview(*folder, colors, pictures);
  output.write(color_file_bytes(colors.table));
  throw_if_interrupted();
  output.commit();
  if (folder) folder->commit();
  write_json_results(options.common, to_json(colors, pictures));
  if (!options.common.quiet) {
    print_summary(colors);
    fmt::print("Written to {}\n", options.output.string());
  }
  return exit_done;
}

}  // namespace

void add_calibrate_colors_command(CLI::App& calibrate, Action& action) {
  auto options = std::make_shared<ColorsOptions>();
  CLI::App* command = calibrate.add_subcommand("colors", "Learn the colours of balls from pictures of them");
  command->footer(
      "Examples:\n"
      "  ballservo calibrate colors smarties.png -o my.colors --preview preview/\n"
      "  ballservo calibrate colors --class green=hand.png --at green=645,312,58 -o green.colors\n"
      "\n"
      "Bare pictures: every colour whose regions are round becomes a class, named red, orange, yellow, "
      "green, cyan,\n"
      "blue, purple or pink (red_2 where two share a word). With --class the name is yours; where a picture "
      "shows\n"
      "round things of several colours, a name that is a colour word says which is meant, and --at any "
      "other.\n"
      "Dark and nearly grey pixels (L below 10, chroma below 8: black things, deep shade, glare) have no "
      "class.\n"
      "Exit: 0 learnt, 1 nothing round and coloured found or not clear which, 2 bad input.");
  command->add_option("IMAGE", options->sources, "Pictures of balls, or folders of them");
  command->add_option("--class", options->classes, "Learn one class from these pictures; may be repeated")
      ->type_name("NAME=IMAGE[,IMAGE...]")
      ->allow_extra_args(false);
  command->add_option("--at", options->at, "Where the ball is in that class's first picture (px)")
      ->type_name("NAME=CX,CY,R")
      ->allow_extra_args(false);
  command
      ->add_option("--background", options->background, "Pictures without any ball: what is not to be a ball")
      ->type_name("IMAGE,...")
      ->delimiter(',')
      ->allow_extra_args(false);
  command->add_option("-o,--output", options->output, "The colours file")->type_name("FILE.colors");
  command->add_option("--preview", options->preview, "How it was learnt, picture by picture")
      ->type_name("DIR");
  command->add_option("--show", options->show, "Say what a colours file holds, learning nothing")
      ->type_name("FILE");
  add_common_options(*command, options->common);
  command->callback([options, &action] { action = [options] { return run_calibrate_colors(*options); }; });
}

}  // namespace ballservo
