#include "app/io/image_source.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <map>
#include <opencv2/videoio.hpp>
#include <set>
#include <string_view>
#include <utility>

#include "app/io/live_camera.hpp"
#include "app/io/recording.hpp"
#include "calibration/base/fault.hpp"
#include "calibration/base/numbers.hpp"
#include "calibration/base/system_file.hpp"
#include "calibration/pictures/image_file.hpp"

namespace fs = std::filesystem;

namespace ballservo {
namespace {

constexpr const char* allowed_sources = "image files, a folder of images, a video file, or camera:N";
constexpr std::string_view camera_prefix = "camera:";

enum class SourceKind { image, folder, video, camera };

struct Source {
  SourceKind kind = SourceKind::image;
  std::string text;             ///< as it was given
  std::vector<fs::path> files;  ///< the image, the folder's images in natural order, or the video
  std::vector<double> times_s;  ///< of a recording's images, or of rendered ones
  CameraMode camera;
};

/// The file's first bytes, enough for any header that we look at.
std::string head_of(const fs::path& file) {
  std::string head(std::size_t{1} << 16, '\0');
  std::ifstream stream(file, std::ios::binary);
  stream.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(std::max<std::streamsize>(stream.gcount(), 0)));
  return head;
}

/// Told by content: a name proves nothing, and the video library would open playlists that lead to other
/// files or to the network. ISO media (MP4, MOV), Matroska and WebM, AVI, MPEG programme and transport
/// streams, Ogg, Flash video.
bool is_video_container(std::string_view head) {
  using namespace std::string_view_literals;
  const auto at = [&](std::size_t offset, std::string_view magic) {
    return head.size() > offset && head.substr(offset, magic.size()) == magic;
  };
  return at(4, "ftyp") || at(4, "moov") || at(4, "mdat") || at(4, "wide") || at(0, "\x1A\x45\xDF\xA3"sv) ||
         (at(0, "RIFF") && at(8, "AVI ")) || at(0, "\0\0\x01\xBA"sv) || (at(0, "G") && at(188, "G")) ||
         at(0, "OggS") || at(0, "FLV\x01");
}

std::vector<fs::path> images_in_folder(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    const bool hidden = entry.path().filename().string().front() == '.';
    std::error_code ignored;
    if (!hidden && has_image_name(entry.path()) && entry.is_regular_file(ignored))
      files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end(), [](const fs::path& a, const fs::path& b) {
    return natural_less(a.filename().string(), b.filename().string());
  });
  return files;
}

InputError too_large(const std::string& place, const char* what, double width, double height,
                     double max_pixels) {
  return {place, fmt::format("{} of {} x {} pixels", what, width, height),
          fmt::format("at most {:.0f} pixels (--max-pixels sets the limit)", max_pixels)};
}

/// Looks at one file: picture or video. Throws InputError for what is neither.
SourceKind classify_file(const fs::path& file, double max_pixels) {
  const auto fault = [&](const std::string& found) {
    return InputError(file.string(), found, allowed_sources);
  };
  std::error_code error;
  const fs::file_status status = fs::status(file, error);
  if (!fs::exists(status))
    throw fault(status.type() == fs::file_type::not_found ? "no such file"
                                                          : system_error_text(error.value()));
  if (!fs::is_regular_file(status)) throw fault("something that is no regular file");
  const std::string head = head_of(file);
  if (head.empty())
    throw fault(fs::file_size(file, error) == 0 ? "an empty file" : "a file that cannot be read");
  if (is_video_container(head)) return SourceKind::video;
  const auto size = image_size_from_header(head);
  if (size && !(static_cast<double>(size->width_px) * size->height_px <= max_pixels))
    throw too_large(file.string(), "a picture", size->width_px, size->height_px, max_pixels);
  // A JPEG's size may stand behind more metadata than the head holds, a TIFF's behind its pixels; the reader
  // looks again.
  using namespace std::string_view_literals;
  const std::string_view magic = std::string_view(head).substr(0, 4);
  if (size || magic.substr(0, 3) == "\xFF\xD8\xFF" || magic == "II*\0"sv || magic == "MM\0*"sv)
    return SourceKind::image;
  throw fault("neither a picture nor a video");
}

/// A folder of pictures, or a recording. Throws InputError with the faults of all its pictures.
Source classify_folder(const std::string& text, double max_pixels) {
  Source source{SourceKind::folder, text, {}, {}, {}};
  FaultList faults;
  faults.collect([&] {
    for (auto& [file, time_s] : recorded_pictures(text)) {
      source.files.push_back(std::move(file));
      source.times_s.push_back(time_s);
    }
  });
  try {
    if (source.files.empty()) {
      source.files = images_in_folder(text);
      source.times_s = times_in_truth(text, source.files);
    }
    if (source.files.empty())
      faults.add(text, "a folder without pictures",
                 "a folder with .png, .jpg, .bmp, .ppm, .tiff or .webp files");
  } catch (const std::filesystem::filesystem_error& unreadable) {
    faults.add(text, system_error_text(unreadable.code().value()), "a folder that can be read");
  }
  for (const fs::path& file : source.files)
    faults.collect([&] {
      if (classify_file(file, max_pixels) == SourceKind::video)
        throw InputError(file.string(), "a video under a picture's name", "pictures only in a folder");
    });
  faults.throw_if_any();
  return source;
}

Source classify(const std::string& text, double max_pixels) {
  if (text.compare(0, camera_prefix.size(), camera_prefix) == 0) {
    if (const auto mode = parse_camera_mode(text.substr(camera_prefix.size())))
      return {SourceKind::camera, text, {}, {}, *mode};
    throw InputError(text, "no camera number",
                     "camera:N, N from 0 to 255, or camera:N@WxH or camera:N@WxH@HZ");
  }
  std::error_code error;
  if (fs::is_directory(text, error)) return classify_folder(text, max_pixels);
  return {classify_file(text, max_pixels), text, {text}, {}, {}};
}

std::vector<Source> classify_all(const std::vector<std::string>& texts, double max_pixels,
                                 FaultList& faults) {
  if (texts.empty()) faults.add("SOURCE", "nothing", allowed_sources);
  std::vector<Source> sources;
  for (const std::string& text : texts)
    faults.collect([&] { sources.push_back(classify(text, max_pixels)); });
  return sources;
}

class ImageFiles : public FrameSequence {
 public:
  /// `times_s`: one a file, or none.
  ImageFiles(std::string name, std::vector<fs::path> files, std::vector<double> times_s, double fps,
             double max_pixels)
      : name_(std::move(name)),
        files_(std::move(files)),
        times_s_(std::move(times_s)),
        fps_(fps),
        max_pixels_(max_pixels) {}

  std::optional<Frame> next() override {
    if (position_ == files_.size()) return std::nullopt;
    const fs::path& file = files_[position_];
    const double time_s = times_s_.empty() ? static_cast<double>(position_) / fps_ : times_s_[position_];
    ++position_;
    const StoredImage image = read_stored_image(file, max_pixels_);
    return Frame{image.bgr, file.filename().string(), 0, time_s, image.coarse_chroma};
  }
  std::string name() const override { return name_; }
  long length() const override { return static_cast<long>(files_.size()); }
  std::vector<fs::path> files() const override { return files_; }

 private:
  std::string name_;
  std::vector<fs::path> files_;
  std::vector<double> times_s_;
  double fps_, max_pixels_;
  std::size_t position_ = 0;
};

/// The EXIF orientation that shows a video's pictures upright. OpenCV 4.6 counts the turn counter-clockwise,
/// all other versions clockwise (https://github.com/opencv/opencv/issues/22088).
int orientation_of(const cv::VideoCapture& capture) {
  constexpr bool counter_clockwise = CV_VERSION_MAJOR == 4 && CV_VERSION_MINOR == 6;
  switch (static_cast<int>(capture.get(cv::CAP_PROP_ORIENTATION_META))) {
    case 90:
      return counter_clockwise ? 8 : 6;
    case 180:
      return 3;
    case 270:
      return counter_clockwise ? 6 : 8;
    default:
      return 1;
  }
}

class VideoFrames : public FrameSequence {
 public:
  /// Reads the first picture at once, so that a file without any is a fault before work begins.
  VideoFrames(const fs::path& file, double fps, double max_pixels)
      : path_(file.string()), name_(file.filename().string()) {
    constexpr const char* readable_video = "a video that this machine's OpenCV can read";
    bool opened = false;
    try {
      // Not by its name, which FFmpeg would take for an address (http:, concat:) or a pattern (%03d) of
      // others.
      const Descriptor opened_file = open_regular_file(file);
      opened = capture_.open(fmt::format("/proc/self/fd/{}", opened_file.number()), cv::CAP_FFMPEG);
    } catch (const cv::Exception&) {
      opened = false;
    }
    if (!opened) throw InputError(path_, "a damaged video or an unknown codec", readable_video);
    const double width = capture_.get(cv::CAP_PROP_FRAME_WIDTH),
                 height = capture_.get(cv::CAP_PROP_FRAME_HEIGHT);
    if (!(width * height <= max_pixels)) throw too_large(path_, "a video", width, height, max_pixels);
    capture_.set(cv::CAP_PROP_ORIENTATION_AUTO, 0);  // OpenCV 4.6 turns the wrong way
    orientation_ = orientation_of(capture_);
    const double own_fps = capture_.get(cv::CAP_PROP_FPS);
    fps_ = std::isfinite(own_fps) && own_fps > 0 && own_fps < 1e5 ? own_fps : fps;
    const double count = capture_.get(cv::CAP_PROP_FRAME_COUNT);
    if (count > 0 && count < 1e9) length_ = static_cast<long>(count);
    read();
    if (!ahead_) throw InputError(path_, "a video without a readable picture", readable_video);
  }

  std::optional<Frame> next() override {
    std::optional<Frame> frame = std::exchange(ahead_, std::nullopt);
    if (frame) read();
    return frame;
  }
  std::string name() const override { return name_; }
  long length() const override { return length_; }
  std::vector<fs::path> files() const override { return {path_}; }

 private:
  void read() {
    cv::Mat picture;
    try {
      if (!capture_.read(picture) || picture.type() != CV_8UC3) return;
    } catch (const cv::Exception&) {
      return;  // a damaged rest ends the sequence, as the end of the file does
    }
    const double stamp_s = capture_.get(cv::CAP_PROP_POS_MSEC) / 1000;
    if (count_ == 0) first_stamp_s_ = std::isfinite(stamp_s) ? stamp_s : 0;
    const double time_s = stamp_s - first_stamp_s_;
    // Some containers hold no stamps, or repeat them: then the frame rate tells the time.
    time_s_ = count_ == 0 ? 0 : time_s > time_s_ ? time_s : time_s_ + 1 / fps_;
    ahead_ = Frame{upright(picture, orientation_).clone(), name_, count_++, time_s_, true};
  }

  std::string path_, name_;
  cv::VideoCapture capture_;
  double fps_ = 30, first_stamp_s_ = 0, time_s_ = 0;
  long length_ = 0;
  int count_ = 0, orientation_ = 1;
  std::optional<Frame> ahead_;
};

}  // namespace

bool has_image_name(const fs::path& file) {
  static const std::set<std::string> extensions = {".png", ".jpg", ".jpeg", ".bmp",  ".pbm", ".pgm",
                                                   ".ppm", ".pnm", ".tif",  ".tiff", ".webp"};
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  return extensions.count(extension) > 0;
}

std::vector<std::unique_ptr<FrameSequence>> open_sources(const std::vector<std::string>& texts, double fps,
                                                         double max_pixels) {
  FaultList faults;
  if (!fps_range().contains(fps)) faults.add("--fps", fmt::format("{}", fps), fps_range().to_text());
  const std::vector<Source> sources = classify_all(texts, max_pixels, faults);
  std::vector<std::unique_ptr<FrameSequence>> sequences;
  std::vector<fs::path> single_files;
  std::size_t place_of_files = 0;
  for (const Source& source : sources) {
    if (source.kind == SourceKind::image) {
      if (single_files.empty()) place_of_files = sequences.size();
      single_files.push_back(source.files.front());
    } else if (source.kind == SourceKind::folder) {
      sequences.push_back(
          std::make_unique<ImageFiles>(source.text, source.files, source.times_s, fps, max_pixels));
    } else if (source.kind == SourceKind::video) {
      faults.collect(
          [&] { sequences.push_back(std::make_unique<VideoFrames>(source.files.front(), fps, max_pixels)); });
    } else if (source.kind == SourceKind::camera && faults.empty()) {
      faults.collect([&] { sequences.push_back(open_live_camera(source.camera, max_pixels)); });
    }
  }
  faults.throw_if_any();
  if (!single_files.empty()) {
    const std::string name = single_files.size() == 1 ? single_files.front().filename().string() : "images";
    sequences.insert(
        sequences.begin() + static_cast<std::ptrdiff_t>(place_of_files),
        std::make_unique<ImageFiles>(name, std::move(single_files), std::vector<double>(), fps, max_pixels));
  }
  return sequences;
}

std::vector<SourceFile> source_files(const std::vector<std::string>& texts) {
  FaultList faults;
  std::vector<SourceFile> files;
  // The reader that follows knows the limit of --max-pixels.
  for (const Source& source : classify_all(texts, std::numeric_limits<double>::infinity(), faults)) {
    if (source.kind == SourceKind::camera) files.push_back({source.text, SourceFile::Kind::camera});
    for (const fs::path& file : source.files)
      files.push_back(
          {file, source.kind == SourceKind::video ? SourceFile::Kind::video : SourceFile::Kind::image});
  }
  faults.throw_if_any();
  return files;
}

std::vector<std::string> repeated_names(const std::vector<std::unique_ptr<FrameSequence>>& sequences) {
  std::map<std::string, std::set<fs::path>> files;
  for (const auto& sequence : sequences) {
    for (const fs::path& file : sequence->files()) {
      std::error_code error;
      files[file.filename().string()].insert(fs::weakly_canonical(file, error));
    }
  }
  std::vector<std::string> repeated;
  for (const auto& [name, paths] : files) {
    if (paths.size() > 1) repeated.push_back(name);
  }
  return repeated;
}

std::vector<fs::path> image_files(const std::vector<std::string>& texts, const std::string& allowed) {
  FaultList faults;
  std::vector<fs::path> files;
  for (const SourceFile& file : source_files(texts)) {
    if (file.kind != SourceFile::Kind::image)
      faults.add(file.path.string(), file.kind == SourceFile::Kind::video ? "a video" : "a camera", allowed);
    files.push_back(file.path);
  }
  faults.throw_if_any();
  return files;
}

}  // namespace ballservo
