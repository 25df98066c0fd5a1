#include "app/io/recording.hpp"

#include <fmt/format.h>

#include <boost/asio/post.hpp>
#include <chrono>
#include <utility>

#include "app/io/ball_rows.hpp"
#include "app/report/picture.hpp"
#include "calibration/base/csv_table.hpp"
#include "calibration/base/fault.hpp"
#include "calibration/base/system_file.hpp"

namespace fs = std::filesystem;

namespace ballservo {
namespace {

constexpr std::size_t most_waiting_bytes = std::size_t{256} << 20;
const std::vector<int> fast_png{cv::IMWRITE_PNG_COMPRESSION, 1};
constexpr const char* rows_table = "tracks.csv";
constexpr const char* recording_columns = "source,time_s,captured_unix_s\n";
constexpr CsvLimits recording_limits{std::size_t{256} << 20, 4000000, 3};

bool is_of_recording(const fs::path& file) {
  const std::string name = file.filename().string();
  return name == recording_table || name == rows_table || name.rfind("frame_", 0) == 0;
}

/// Nobody sees half of it: it is written under a hidden name first.
void write_whole(const fs::path& file, std::string_view contents) {
  const fs::path hidden = file.parent_path() / ("." + file.filename().string());
  write_bytes(hidden, contents, file.string());
  rename_path(hidden, file, true);
}

std::string picture_name(long number) { return fmt::format("frame_{:07}.png", number); }

/// Makes the folder, or empties one of an earlier recording.
void begin_folder(const fs::path& folder, Overwrite overwrite) {
  { const OutputFolder checked(folder, overwrite); }  // says what is wrong with it
  make_new_folder(folder, folder.string());
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (is_of_recording(entry.path())) fs::remove(entry.path(), error);
  }
  write_whole(folder / rows_table, ball_rows_header());
  write_whole(folder / recording_table, recording_columns);
}

}  // namespace

void RecentPictures::put(const cv::Mat& bgr, double time_s, double captured_unix_s) {
  using namespace std::chrono_literals;
  if (compressed_.valid()) {
    if (compressed_.wait_for(0s) != std::future_status::ready) return;
    pictures_.push_back(compressed_.get());
    bytes_ += pictures_.back().png->size();
  }
  if (!pictures_.empty() && time_s <= pictures_.back().time_s) pictures_.clear(), bytes_ = 0;
  while (!pictures_.empty() && (pictures_.front().time_s < time_s - seconds_ || bytes_ > most_bytes)) {
    bytes_ -= pictures_.front().png->size();
    pictures_.pop_front();
  }
  compressed_ = std::async(std::launch::async, [bgr, time_s, captured_unix_s] {
    return CompressedPicture{std::make_shared<const std::string>(picture_bytes(bgr, ".png", fast_png)),
                             time_s, captured_unix_s};
  });
}

double RecentPictures::seconds() const {
  return pictures_.empty() ? 0 : pictures_.back().time_s - pictures_.front().time_s;
}

void write_recording(const fs::path& folder, Overwrite overwrite,
                     const std::deque<CompressedPicture>& pictures, const FilesBeside& beside) {
  begin_folder(folder, overwrite);
  for (const auto& [name, contents] : beside) write_whole(folder / name, contents);
  std::string lines = recording_columns;
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    const std::string name = picture_name(static_cast<long>(i));
    write_whole(folder / name, *pictures[i].png);
    lines += csv_row(name, pictures[i].time_s - pictures.front().time_s, pictures[i].captured_unix_s);
  }
  write_whole(folder / recording_table, lines);
}

std::vector<std::pair<fs::path, double>> recorded_pictures(const fs::path& folder) {
  const fs::path file = folder / recording_table;
  std::vector<std::pair<fs::path, double>> pictures;
  std::error_code error;
  if (!fs::is_regular_file(file, error)) return pictures;
  std::string text = read_file_bytes(file, recording_limits.bytes);
  text.resize(text.rfind('\n') + 1);  // a line without its end was under way
  const CsvTable table =
      parse_csv(text, file.string(), {"source", "time_s", "captured_unix_s"}, {}, recording_limits);
  FaultList faults;
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    const CsvRow row(table, i, faults);
    const std::string& name = row.text("source");
    const auto time_s = row.number("time_s", NumberRange::at_least(0, "s"));
    if (name.empty() || fs::path(name).filename() != name || name.front() == '.')
      row.fault("source", "'" + name + "'", "the name of a picture in this folder");
    else if (!time_s || (!pictures.empty() && *time_s <= pictures.back().second))
      row.fault("time_s", row.text("time_s"), "a time after the one before it (s)");
    else
      pictures.emplace_back(folder / name, *time_s);
  }
  faults.throw_if_any();
  return pictures;
}

std::vector<std::string> truth_columns() {
  return {"frame", "ball_id",          "class", "cx_px", "cy_px", "r_px", "x_m", "y_m",
          "z_m",   "visible_fraction", "time_s"};
}

std::vector<double> times_in_truth(const fs::path& folder, const std::vector<fs::path>& pictures) {
  const fs::path file = folder / "truth.csv";
  std::error_code error;
  if (!fs::is_regular_file(file, error)) return {};
  std::vector<double> times;
  try {
    const CsvTable table = read_csv(file, {"source", "time_s"}, truth_columns(),
                                    {recording_limits.bytes, recording_limits.rows, CsvLimits{}.columns});
    FaultList faults;
    std::map<std::string, double> time_of;
    for (std::size_t i = 0; i < table.rows.size(); ++i) {
      const CsvRow row(table, i, faults);
      if (const auto time_s = row.number("time_s", NumberRange::at_least(0, "s")))
        time_of[row.text("source")] = *time_s;
    }
    for (const fs::path& picture : pictures) {
      const auto found = time_of.find(picture.filename().string());
      if (found == time_of.end() || (!times.empty() && found->second <= times.back())) return {};
      times.push_back(found->second);
    }
  } catch (const InputError&) {
    return {};  // a table of somebody else's
  }
  return times;
}

RecordingWriter::RecordingWriter(fs::path folder, Overwrite overwrite) : folder_(std::move(folder)) {
  begin_folder(folder_, overwrite);
}

RecordingWriter::~RecordingWriter() { thread_.join(); }

std::string RecordingWriter::next_name() const { return picture_name(kept_); }

bool RecordingWriter::put(const cv::Mat& bgr, double time_s, double captured_unix_s, std::string rows) {
  const std::size_t bytes = bgr.total() * bgr.elemSize();
  const std::lock_guard lock(mutex_);
  if (!fault_.empty() || bytes_ + bytes > most_waiting_bytes) {
    ++lost_;
    return false;
  }
  bytes_ += bytes;
  boost::asio::post(thread_,
                    [this, item = Item{bgr, next_name(), csv_row(next_name(), time_s, captured_unix_s),
                                       std::move(rows)}] { write(item); });
  ++kept_;
  return true;
}

void RecordingWriter::put_beside(const FilesBeside& files) {
  for (const auto& [name, contents] : files) write_whole(folder_ / name, contents);
}

long RecordingWriter::lost() const {
  const std::lock_guard lock(mutex_);
  return lost_;
}

std::string RecordingWriter::fault() const {
  const std::lock_guard lock(mutex_);
  return fault_;
}

/// After a fault no more is written, only counted.
void RecordingWriter::write(const Item& item) {
  std::string why = fault();
  try {
    if (why.empty()) {
      write_whole(folder_ / item.name, picture_bytes(item.bgr, ".png", fast_png));
      if (!item.rows.empty()) append_bytes(folder_ / rows_table, item.rows, folder_.string());
      append_bytes(folder_ / recording_table, item.line, folder_.string());
    }
  } catch (const std::exception& error) {
    why = error.what();
  }
  const std::lock_guard lock(mutex_);
  bytes_ -= item.bgr.total() * item.bgr.elemSize();
  fault_ = why;
  lost_ += !why.empty();
}

}  // namespace ballservo
