#include "app/comparison/pictures/picture_files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <opencv2/imgproc.hpp>
#include <set>
#include <tuple>

#include "app/comparison/pictures/rendered_frame.hpp"
#include "app/io/recording.hpp"
#include "calibration/base/checksum.hpp"
#include "calibration/base/numbers.hpp"
#include "calibration/base/random.hpp"
#include "calibration/base/strict_yaml.hpp"
#include "calibration/base/system_file.hpp"
#include "calibration/camera/files/camera_file.hpp"
#include "calibration/color/color_file.hpp"
#include "calibration/pictures/image_file.hpp"

namespace fs = std::filesystem;

namespace ballservo {
namespace {

// How far votes lie from the truth: measured on rendered balls of 30 to 180 px (README).
constexpr double vote_center_px = 0.6, vote_center_part = 0.02, vote_radius_share = 0.5;
constexpr std::size_t most_file_bytes = 256u << 20;

// Three cells of a row: all of them, or none.
std::optional<Eigen::Vector3d> triple(const CsvRow& row, const std::array<std::string, 3>& names,
                                      const std::array<NumberRange, 3>& ranges) {
  std::array<std::optional<double>, 3> values;
  int known = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    values[k] = row.number(names[k], ranges[k]);
    known += row.text(names[k]).empty() ? 0 : 1;
  }
  if (known > 0 && known < 3)
    row.fault(names[0], "some of " + names[0] + ", " + names[1] + ", " + names[2], "all three or none");
  if (!values[0] || !values[1] || !values[2]) return std::nullopt;
  return Eigen::Vector3d(*values[0], *values[1], *values[2]);
}

FrameTruth read_truth(const CsvRow& row) {
  FrameTruth truth;
  truth.source = row.text("source");
  if (const std::string frame = row.text("frame"); !frame.empty() && parse_integer(frame) != 0)
    row.fault("frame", frame, "0 or nothing: every row is of a still");
  const NumberRange px = NumberRange::within(-1e5, 1e5, "px"), m = NumberRange::within(-1e4, 1e4, "m");
  if (const auto circle = triple(row, {"cx_px", "cy_px", "r_px"}, {px, px, NumberRange::above(0, 1e5, "px")}))
    truth.outline = OutlineEllipse{circle->head<2>(), circle->z()};
  truth.p_CB = triple(row, {"x_m", "y_m", "z_m"}, {m, m, NumberRange::above(0, 1e4, "m")});
  truth.visible_fraction = row.number("visible_fraction", NumberRange::within(0, 1, ""));
  return truth;
}

// As OpenCV counts it: the most frequent hue of the saturated pixels inside the ball's circle.
int most_frequent_hue(const FrameTruth& truth, const cv::Mat& bgr) {
  if (!truth.outline) return 0;
  const OutlineEllipse& ball = *truth.outline;
  const int reach_px = std::max(1, static_cast<int>(0.6 * ball.radius_px));
  const cv::Rect box = square_around(ball.center_px, reach_px) & cv::Rect({0, 0}, bgr.size());
  if (box.empty()) return 0;
  cv::Mat hsv;
  cv::cvtColor(bgr(box), hsv, cv::COLOR_BGR2HSV);
  std::array<int, 180> counts{};
  for (int v = 0; v < hsv.rows; ++v) {
    for (int u = 0; u < hsv.cols; ++u) {
      const cv::Vec3b& pixel = hsv.at<cv::Vec3b>(v, u);
      if (pixel[1] > 60) ++counts[std::min<std::size_t>(pixel[0], 179)];
    }
  }
  return static_cast<int>(std::max_element(counts.begin(), counts.end()) - counts.begin());
}

// A class's name as a condition's.
std::string condition_name(const std::string& class_name) {
  std::string name;
  for (const char c : class_name) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9');
    const bool upper = c >= 'A' && c <= 'Z';
    name += plain ? c : upper ? static_cast<char>(c - 'A' + 'a') : '_';
  }
  return name.empty() ? "pictures" : name.substr(0, 64);
}

// The fits need a class even where no colours tell one.
std::shared_ptr<const ColorTable> no_colors() {
  auto table = std::make_shared<ColorTable>();
  table->classes.emplace_back();
  table->classes.back().name = "ball";
  return table;
}

}  // namespace

PictureFiles::PictureFiles(const PictureFilesOptions& options) : options_(options), colors_(no_colors()) {
  FaultList faults;
  std::string hashes = options.start_at_truth ? "truth" : "vote";
  hashes += number_text(options.diameter_m) + std::to_string(options.seed) + read_colors_and_camera(faults);
  CsvTable table;
  faults.collect([&] { table = read_csv(options.truth, {"source"}, truth_columns()); });
  if (!fs::is_directory(options.folder))
    faults.add("--images", options.folder.string(), "a folder of pictures");
  faults.throw_if_any();

  std::set<std::tuple<std::string, std::string, std::string>> seen;
  std::map<std::string, std::string> picture_hashes;
  for (std::size_t r = 0; r < table.rows.size(); ++r) {
    const CsvRow reader(table, r, faults);
    auto row = read_row(reader);
    if (!row) continue;
    const std::string& source = row->truth.source;
    const std::string id = reader.text("ball_id");
    if (!seen.insert({source, id, row->class_name}).second)
      reader.fault("ball_id", fmt::format("{}, as in another row of {}", id.empty() ? "nothing" : id, source),
                   "one row for each ball: another ball_id or class");
    if (picture_hashes.count(source) == 0)
      faults.collect([&] { picture_hashes[source] = checked_picture_sha256(row->file); });
    keep(std::move(*row));
  }
  if (table.rows.empty()) faults.add(options.truth.string(), "no rows", "a row for each ball");
  faults.throw_if_any();
  for (const auto& [name, hash] : picture_hashes) hashes += name + hash;
  hashes += sha256_hex(read_file_bytes(options.truth, most_file_bytes));
  sha256_ = sha256_hex(hashes);
}

// Gives what identifies them.
std::string PictureFiles::read_colors_and_camera(FaultList& faults) {
  std::string hashes;
  if (!options_.colors.empty()) {
    faults.collect([&] {
      colors_ = std::make_shared<const ColorTable>(read_color_file(options_.colors));
      hashes += sha256_hex(read_file_bytes(options_.colors, most_file_bytes));
    });
  } else if (!options_.start_at_truth) {
    faults.add("--colors", "nothing",
               "a colours file, or --start truth: something must tell where a ball is");
  }
  if (!options_.camera.empty()) {
    faults.collect([&] {
      const Camera camera = read_camera(options_.camera);
      rays_ = std::make_shared<const RayTable>(camera);
      hashes += camera_file_text(camera, camera_file_format("opencv", "camera.yaml"), "");
    });
  }
  return hashes;
}

// Nothing where there is no such picture.
std::optional<PictureFiles::Row> PictureFiles::read_row(const CsvRow& reader) const {
  Row row;
  row.truth = read_truth(reader);
  row.class_name = reader.text("class");
  const std::string& source = row.truth.source;
  row.file = options_.folder / source;
  if (source.empty() || source.find('/') != std::string::npos || !fs::is_regular_file(row.file)) {
    reader.fault("source", "'" + source + "'", "a picture in " + options_.folder.string());
    return std::nullopt;
  }
  if (options_.start_at_truth && !row.truth.outline)
    reader.fault("cx_px", "nothing", "the ball's circle: with --start truth the fits begin there");
  if (options_.colors.empty()) return row;
  const bool only_one = row.class_name.empty() && colors_->classes.size() == 1;
  const auto known = only_one ? std::optional<ClassIndex>(ClassIndex{1}) : colors_->find(row.class_name);
  if (!known)
    reader.fault("class", "'" + row.class_name + "'",
                 fmt::format("a class of the colours: {}", fmt::join(colors_->class_names(), ", ")));
  row.color_class = known.value_or(ClassIndex{1});
  return row;
}

// Throws InputError for what is no picture, or one of another size than the camera's.
std::string PictureFiles::checked_picture_sha256(const fs::path& file) const {
  const std::string bytes = read_file_bytes(file, most_file_bytes);
  const auto size = image_size_from_header(bytes);
  if (!size) throw InputError(file.string(), "no picture that can be read", "a PNG, JPEG or other picture");
  if (rays_) check_camera_fits(rays_->camera(), *size, "--camera", file.string());
  return sha256_hex(bytes);
}

// Each class is a condition, in the order in which the rows name them.
void PictureFiles::keep(Row row) {
  const std::string name = condition_name(row.class_name);
  const std::size_t place = places_.emplace(name, rows_.size()).first->second;
  if (place == rows_.size()) {
    rows_.emplace_back();
    infos_.push_back({name, row.class_name.empty() ? "pictures" : row.class_name + " balls in pictures", 0,
                      "", "", 0, false});
  }
  rows_[place].push_back(std::move(row));
  ++infos_[place].frames;
}

std::shared_ptr<const RayTable> PictureFiles::rays_of(const cv::Mat& bgr) const {
  return rays_ ? rays_ : std::make_shared<const RayTable>(long_lens_camera({bgr.cols, bgr.rows}));
}

ComparisonPicture PictureFiles::picture(std::size_t condition, int frame) const {
  const Row& row = rows_[condition][static_cast<std::size_t>(frame)];
  ComparisonPicture picture;
  picture.truth = row.truth;
  picture.bgr = read_color_image(row.file, options_.max_pixels);
  picture.detector.rays = rays_of(picture.bgr);
  picture.detector.colors = colors_;
  // Without a camera a position would mean nothing.
  const double radius_m = rays_ ? options_.diameter_m / 2 : 0;
  picture.detector.options.radii.assign(std::max<std::size_t>(1, colors_->classes.size()), {radius_m, 0});
  picture.detector.options.seed = options_.seed;
  MethodTask& task = picture.task;
  task.color_class = row.color_class;
  task.hue = most_frequent_hue(row.truth, picture.bgr);
  if (!row.truth.outline) return picture;
  const OutlineEllipse& ball = *row.truth.outline;
  RandomEngine engine = random_stream(options_.seed, "start/" + row.class_name + "/" + row.truth.source,
                                      static_cast<std::uint64_t>(frame));
  task.near_px = task.click_px = ball.center_px;
  task.expected_radius_px = ball.radius_px;
  if (options_.start_at_truth) {
    const double sigma_px = std::max(vote_center_px, vote_center_part * ball.radius_px);
    task.start = displaced_start(picture.detector.rays->camera(), ball, sigma_px,
                                 vote_radius_share * sigma_px, engine);
  }
  return picture;
}

}  // namespace ballservo
