// ballservo calibrate colors: which colours the balls have.
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <set>

#include "app/commands/ball_options.hpp"
#include "app/commands/color_requests.hpp"
#include "app/commands/command.hpp"
#include "app/io/image_source.hpp"
#include "app/io/interrupt.hpp"
#include "app/io/progress.hpp"
#include "app/report/color_preview.hpp"
#include "app/report/draw_pages.hpp"
#include "app/report/overlay.hpp"
#include "app/report/picture.hpp"
#include "calibration/base/fault.hpp"
#include "calibration/base/numbers.hpp"
#include "calibration/color/color_file.hpp"
#include "calibration/teaching/box_trainer.hpp"
#include "calibration/teaching/class_report.hpp"
#include "calibration/teaching/learn_colors.hpp"
#include "calibration/teaching/merge_colors.hpp"

namespace ballservo {
namespace {

long table_cells_of(const ColorTable& colors, std::size_t k) {
  return std::count(colors.table.begin(), colors.table.end(), static_cast<ClassIndex>(k + 1));
}

/// Only as many digits as mean something.
std::string rounded_k(double temperature_k) {
  return fmt::format("{:.0f}", 100 * std::round(temperature_k / 100));
}

/// The figures of every class; `circles` of those learnt now, with the names of their pictures.
nlohmann::json classes_json(const ColorTable& colors, const std::vector<ClassReport>& reports,
                            const LearntCircles& circles, const std::vector<std::string>& sources) {
  nlohmann::json classes = nlohmann::json::object();
  for (std::size_t k = 0; k < reports.size(); ++k) {
    const ClassReport& report = reports[k];
    const ColorClass& color = colors.classes[k];
    nlohmann::json listed = nlohmann::json::array();
    if (const auto learnt = circles.find(color.name); learnt != circles.end()) {
      for (const LearntCircle& circle : learnt->second) {
        listed.push_back({{"source", sources.at(circle.picture)},
                          {"frame", circle.frame},
                          {"cx_px", circle.center_px.x()},
                          {"cy_px", circle.center_px.y()},
                          {"r_px", circle.radius_px},
                          {"fit_ratio", circle.fit_ratio}});
      }
    }
    classes[color.name] = {{"samples", color.samples},
                           {"circles", listed},
                           {"table_cells", table_cells_of(colors, k)},
                           {"kept_fraction", report.kept_fraction},
                           {"overlap", report.overlap},
                           {"shared", report.shared},
                           {"background_fraction", report.background_fraction},
                           {"chroma", report.chroma},
                           {"dissolves_at_chroma", report.dissolves_at_chroma},
                           {"light",
                            {{"level_low", report.light.level_low},
                             {"level_high", report.light.level_high},
                             {"warmest_k", report.light.warmest_k},
                             {"coolest_k", report.light.coolest_k},
                             {"warmer_mired", report.light.warmer_mired},
                             {"cooler_mired", report.light.cooler_mired}}}};
  }
  return classes;
}

/// The same in plain words, some lines a class.
std::string classes_text(const ColorTable& colors, const std::vector<ClassReport>& reports,
                         const LearntCircles& circles) {
  std::string text;
  for (std::size_t k = 0; k < reports.size(); ++k) {
    const ClassReport& report = reports[k];
    const ColorClass& color = colors.classes[k];
    text += color.name + ": ";
    if (const auto learnt = circles.find(color.name); learnt != circles.end()) {
      text += counted(static_cast<long>(learnt->second.size()), "ball") + ", ";
    }
    text += fmt::format("{} pixels, {} cells of the table, which gives {:.1f} % of the pixels back",
                        color.samples, table_cells_of(colors, k), 100 * report.kept_fraction);
    for (const auto& [other, fraction] : report.overlap) {
      if (fraction >= 0.01) text += fmt::format(", {:.1f} % to {}", 100 * fraction, other);
    }
    text += fmt::format("\n  background: {:.2f} % of the pixels off the balls have this colour\n",
                        100 * report.background_fraction);
    text += fmt::format("  chroma {:.0f}; fading towards grey, it is lost below {:.0f}\n", report.chroma,
                        report.dissolves_at_chroma);
    text += fmt::format(
        "  light: most of it stays from {:.2g} to {:.2g} times the strength, and from {} to {} K if it was "
        "taught at 6500 K\n",
        report.light.level_low, report.light.level_high, rounded_k(report.light.warmest_k),
        rounded_k(report.light.coolest_k));
  }
  return text;
}

struct ColorsOptions {
  CommonOptions common;
  std::vector<std::string> sources, classes, at, background, add;
  std::string from, box;
  std::filesystem::path output, preview, show;
};

/// The panels and their figure as files whose names begin with `prefix`; returns what the page says of them.
nlohmann::ordered_json write_panels(const OutputFolder& folder, const std::string& prefix,
                                    const std::vector<PreviewPanel>& panels) {
  nlohmann::ordered_json listed = nlohmann::json::array();
  for (const PreviewPanel& panel : panels) {
    listed.push_back(
        {{"name", panel.name}, {"file", prefix + panel.name + ".png"}, {"caption", panel.caption}});
    folder.write(listed.back()["file"], picture_bytes(panel.picture, ".png"));
  }
  folder.write(prefix + "figure.png", picture_bytes(preview_figure(panels), ".png"));
  return listed;
}

/// What was learnt, and how to draw it.
struct Lesson {
  LearntColors colors;
  std::vector<ColorPicture> pictures;    // that it was learnt from, none for a video
  std::vector<BoxTrainer::Shown> shown;  // frames of a video
  std::vector<std::string> sources;      // what LearntCircle::picture counts
};

/// The panels of every picture, and the page about the classes of the file.
void write_preview(const OutputFolder& folder, const Lesson& lesson, const std::string& file,
                   nlohmann::json classes, const std::vector<std::string>& warnings, bool quiet) {
  const ColorTable& colors = lesson.colors.table;
  nlohmann::ordered_json pictures = nlohmann::json::array();
  const auto add = [&](const std::string& prefix, const std::vector<PreviewPanel>& panels) {
    throw_if_interrupted();
    pictures.push_back(write_panels(folder, prefix, panels));
  };
  if (lesson.sources.empty()) add("", color_preview(colors));
  for (const BoxTrainer::Shown& shown : lesson.shown)
    add(fmt::format("frame_{:06}_", shown.frame), box_preview(colors, shown));
  std::set<std::string> used;
  for (std::size_t i = 0; i < lesson.pictures.size(); ++i) {
    const std::string stem = std::filesystem::path(lesson.pictures[i].source).stem().string();
    add(unused_name(used, stem) + "_", color_preview(lesson.colors, lesson.pictures, i));
  }
  for (std::size_t k = 0; k < colors.classes.size(); ++k) {
    const cv::Scalar bgr = class_display_color(colors, static_cast<ClassIndex>(k + 1));
    classes[colors.classes[k].name]["rgb"] = {bgr[2], bgr[1], bgr[0]};
  }
  write_report(folder,
               {{"page", "colors"},
                {"file", file},
                {"sources", lesson.sources},
                {"classes", classes},
                {"camera_settings", colors.camera_settings},
                {"warnings", warnings},
                {"pictures", pictures}},
               quiet);
}

/// Says, draws and writes what the classes are; to `output` what was learnt now.
int finish_lesson(const ColorsOptions& options, const Lesson& lesson, const std::vector<ClassReport>& reports,
                  const std::vector<std::string>& warnings, std::optional<OutputFile>& output,
                  std::optional<OutputFolder>& folder) {
  const ColorTable& colors = lesson.colors.table;
  const nlohmann::json classes = classes_json(colors, reports, lesson.colors.circles, lesson.sources);
  for (const std::string& warning : warnings) spdlog::warn("{}", warning);
  if (folder) {
    const std::filesystem::path& file = output ? options.output : options.show;
    write_preview(*folder, lesson, file.filename().string(), classes, warnings, options.common.quiet);
  }
  if (output) output->write(color_file_bytes(colors));
  throw_if_interrupted();
  options.common.files->commit(output, folder);
  write_json_results(options.common, {{"classes", classes}, {"camera_settings", colors.camera_settings}});
  if (options.common.quiet) return exit_done;
  print_result("{}", classes_text(colors, reports, lesson.colors.circles));
  for (const auto& [name, value] : colors.camera_settings)
    print_result("camera {}: {}\n", name, number_text(value));
  if (output) print_result("Written to {}\n", options.output.string());
  if (folder)
    print_result("report: {}\n", std::filesystem::absolute(options.preview / "report.html").string());
  return exit_done;
}

int show_file(const ColorsOptions& options) {
  FaultList faults;
  if (!options.sources.empty()) faults.add("--show", "pictures", "--show FILE with nothing to learn");
  if (!options.classes.empty() || !options.at.empty() || !options.background.empty() ||
      !options.add.empty() || !options.from.empty() || !options.box.empty() || !options.output.empty()) {
    faults.add("--show", "options to learn with", "--show FILE, --preview and --json alone");
  }
  faults.throw_if_any();
  Lesson lesson;
  lesson.colors.table = read_color_file(options.show);
  std::optional<OutputFile> no_output;
  std::optional<OutputFolder> folder;
  if (!options.preview.empty()) folder.emplace(options.preview, options.common.overwrite(options.preview));
  const std::vector<ClassReport> reports = report_classes(lesson.colors.table);
  return finish_lesson(options, lesson, reports, judge_classes(lesson.colors.table, reports).warnings,
                       no_output, folder);
}

constexpr int most_camera_frames = 900;

Lesson learn_from_box(const ColorsOptions& options, const std::pair<std::string, PointedBall>& box,
                      const std::vector<ColorPicture>& background) {
  auto sequences = open_sources({options.from}, 30, options.common.max_pixels);
  FrameSequence& sequence = *sequences.front();
  Progress progress("circles looked at", 0, options.common.quiet);
  RegionSearchOptions search;
  search.before_each_test = [&progress, asked = 0L]() mutable {
    throw_if_interrupted();
    progress.step(++asked);
  };
  BoxTrainer lesson(box.first, box.second, search);
  // A recorded video ends; a camera would show an empty box for ever.
  const bool ends = !sequence.files().empty();
  while (!lesson.enough() && (ends || lesson.looked_at() < most_camera_frames)) {
    throw_if_interrupted();
    const auto frame = sequence.next();
    if (!frame) break;
    lesson.look(frame->bgr, lesson.looked_at());  // stills of a folder count as frames too
  }
  Lesson result{lesson.finish(background), {}, lesson.shown(), {sequence.name()}};
  result.colors.table.camera_settings = sequence.camera_settings();
  return result;
}

/// The files of --add, and what was learnt now, as one table. Bare pictures name their classes by themselves,
/// so that a class may take the name of the one it is.
ColorTable joined(const ColorsOptions& options, Lesson& lesson, std::vector<ColorTable> files) {
  if (files.empty()) return std::move(lesson.colors.table);
  if (!options.sources.empty()) {
    const std::vector<std::string> names = names_to_join(lesson.colors.table, merge_colors(files));
    LearntCircles circles;
    for (std::size_t k = 0; k < names.size(); ++k) {
      ColorClass& color = lesson.colors.table.classes[k];
      const auto& of_class = lesson.colors.circles[color.name];
      circles[names[k]].insert(circles[names[k]].end(), of_class.begin(), of_class.end());
      color.name = names[k];
    }
    lesson.colors.circles = std::move(circles);
  }
  if (!lesson.colors.table.classes.empty()) files.push_back(std::move(lesson.colors.table));
  return merge_colors(files);
}

/// What was learnt from and `detect` does not see, in words.
std::vector<std::string> unseen_balls(const Lesson& lesson, const CommonOptions& common) {
  std::vector<std::string> unseen;
  BallOptions balls;
  balls.color_table = std::make_shared<const ColorTable>(lesson.colors.table);
  const DetectorFactory factory(balls, common);
  Progress progress("pictures looked at", static_cast<long>(lesson.pictures.size()), common.quiet);
  for (std::size_t i = 0; i < lesson.pictures.size(); ++i) {
    throw_if_interrupted();
    progress.step(static_cast<long>(i));
    const cv::Mat& bgr = lesson.pictures[i].bgr;
    Detector detector = factory.make({bgr.cols, bgr.rows}, lesson.pictures[i].source, {true, false});
    std::vector<BallObservation> seen = detector.detect(bgr);
    for (const BallObservation& ball : detector.detect_thoroughly(bgr)) seen.push_back(ball);
    for (const auto& [name, circles] : lesson.colors.circles)
      for (const LearntCircle& circle : circles) {
        const auto is_there = [&, name = name](const BallObservation& ball) {
          return detector.colors().name_of(ball.color_class) == name &&
                 (ball.outline.center_px - circle.center_px).norm() < circle.radius_px;
        };
        if (circle.picture != i || std::any_of(seen.begin(), seen.end(), is_there)) continue;
        unseen.push_back(fmt::format(
            "detect does not see the {} ball around ({:.0f}, {:.0f}) px in {} itself: too little of its "
            "outline or colour shows. Learn from a picture that shows it better",
            name, circle.center_px.x(), circle.center_px.y(), lesson.pictures[i].source));
      }
  }
  return unseen;
}

int run_calibrate_colors(const ColorsOptions& options) {
  if (!options.show.empty()) return show_file(options);
  FaultList faults;
  if (options.output.empty()) faults.add("-o", "nothing", "the colours file to write");
  const int ways = !options.sources.empty() + !options.classes.empty() + !options.from.empty();
  if (ways > 1 || (ways == 0 && options.add.empty())) {
    faults.add("calibrate colors", ways > 1 ? "several of pictures, --class and --from" : "no picture",
               "IMAGE..., --class NAME=IMAGE, --from VIDEO --box NAME=CX,CY,R, or --add FILE alone to merge");
  }
  if (ways == 0 && !options.background.empty())
    faults.add("--background", "no picture of a ball", "IMAGE..., --class or --from beside it");
  PictureSet set, off_set;
  faults.collect([&] {
    if (!options.sources.empty()) set.add(options.sources);
  });
  std::vector<ClassRequest> requests = parse_classes(options.classes, set, faults);
  parse_pointed_balls(options.at, requests, faults);
  std::optional<std::pair<std::string, PointedBall>> box;
  if (options.from.empty() != options.box.empty()) {
    faults.add("--from, --box", options.from.empty() ? "--box alone" : "--from alone",
               "both: --from VIDEO|camera:N --box NAME=CX,CY,R");
  } else if (!options.box.empty()) {
    box = parse_ball("--box", options.box, faults);
  }
  faults.collect([&] {
    if (!options.background.empty()) off_set.add(options.background);
  });
  if (const auto shared = off_set.shared_with(set))
    faults.add("--background", shared->string() + ", which is to be learnt from",
               "pictures without any ball");
  std::vector<ColorTable> files;
  for (const std::string& file : options.add) faults.collect([&] { files.push_back(read_color_file(file)); });
  faults.throw_if_any();
  std::optional<OutputFile> output(std::in_place, options.output, options.common.overwrite(options.output));
  std::optional<OutputFolder> folder;
  if (!options.preview.empty()) folder.emplace(options.preview, options.common.overwrite(options.preview));

  Lesson lesson;
  const std::vector<ColorPicture> background = off_set.read(options.common.max_pixels);
  if (box) {
    lesson = learn_from_box(options, *box, background);
  } else if (ways > 0) {
    lesson.pictures = set.read(options.common.max_pixels);
    for (const ColorPicture& picture : lesson.pictures) lesson.sources.push_back(picture.source);
    Progress progress("pictures searched", static_cast<long>(lesson.pictures.size()), options.common.quiet);
    long searched = 0;
    RegionSearchOptions search;
    search.before_each_picture = [&](std::size_t before) { searched = static_cast<long>(before); };
    search.before_each_test = [&] {
      throw_if_interrupted();
      progress.step(searched);
    };
    lesson.colors = requests.empty() ? learn_colors(lesson.pictures, search, background)
                                     : learn_classes(lesson.pictures, requests, search, background);
  }
  lesson.colors.table = joined(options, lesson, std::move(files));
  const std::vector<ClassReport> reports = report_classes(lesson.colors.table);
  std::vector<std::string> warnings = warnings_of(lesson.colors, reports);
  for (std::string& unseen : unseen_balls(lesson, options.common)) warnings.push_back(std::move(unseen));
  return finish_lesson(options, lesson, reports, warnings, output, folder);
}

}  // namespace

void add_calibrate_colors_command(CLI::App& calibrate, Action& action) {
  const auto [command, options] = add_command<ColorsOptions>(
      calibrate, action, "colors", "Learn the colours of balls from pictures of them", run_calibrate_colors);
  command.footer(R"(Examples:
  ballservo calibrate colors smarties.png -o sweets.colors --preview preview/
  ballservo calibrate colors --class green=hand.png --at green=645,312,58 -o green.colors
  ballservo calibrate colors --from camera:0 --box green=320,240,60 -o green.colors --preview preview/
  ballservo calibrate colors --class green=evening.png --add green.colors -o green_all_day.colors
  ballservo calibrate colors --add red.colors --add green.colors -o both.colors
  ballservo calibrate colors --show both.colors --preview preview/

Bare pictures: every colour whose regions are round becomes a class, named red, orange, yellow, green, cyan,
blue, purple or pink (red_2 where two share a word). With --class the name is yours; of several balls a
colour word prefers its own colour; where no thing is clearly the likeliest ball, --at says which is meant.
Beside a ball, things below 16 px across that are less than half as large are left out.
--from: hold the ball where the box is; the first 30 frames with it there are learnt from, and it may drift.
--add: classes of one name are united, from files and from pictures; others join.
Dark and nearly grey pixels (L below 10, chroma below 8 or, in the dark, (L + 16) / 10: black things,
deep shade, glare) have no class.
Exit: 0 learnt; 1 nothing round and coloured found, not clear which, a grey picture, two classes of one colour,
or a class taught on background; 2 bad input.)");
  command.add_option("IMAGE", options.sources, "Pictures of balls, or folders of them");
  add_typed_option(command, "--class", options.classes, "NAME=IMAGE[,IMAGE...]",
                   "Learn one class from these pictures; may be repeated")
      ->allow_extra_args(false);
  add_typed_option(command, "--at", options.at, "NAME=CX,CY,R",
                   "Where the ball is in that class's first picture (px)")
      ->allow_extra_args(false);
  add_typed_option(command, "--background", options.background, "IMAGE,...",
                   "Pictures without any ball: what is not to be a ball")
      ->delimiter(',')
      ->allow_extra_args(false);
  add_typed_option(command, "--add", options.add, "FILE",
                   "A colours file to learn on top of; several are merged")
      ->allow_extra_args(false);
  add_typed_option(command, "--from", options.from, "VIDEO|camera:N",
                   "Live material to learn one class from");
  add_typed_option(command, "--box", options.box, "NAME=CX,CY,R",
                   "Where the ball is held in it (px), and the class's name");
  add_output_option(command, "-o,--output", options.output, "FILE.colors", "The colours file");
  add_output_option(command, "--preview", options.preview, "DIR",
                    "How it was learnt, picture by picture, and what the classes bear: DIR/report.html");
  add_typed_option(command, "--show", options.show, "FILE",
                   "Say what a colours file holds, learning nothing");
  add_common_options(command, options.common);
}

}  // namespace ballservo
