// Pictures as they came, with their times and what was found, kept so that a kill at any moment leaves every
// finished picture.
#pragma once

#include <boost/asio/thread_pool.hpp>
#include <deque>
#include <filesystem>
#include <future>
#include <map>
#include <memory>
#include <mutex>
#include <opencv2/core.hpp>
#include <string>
#include <utility>
#include <vector>

#include "calibration/base/output.hpp"

namespace ballservo {

/// recording.csv in a recording's folder: a picture's file, its time since the first (s), and when it was
/// taken by the calendar (s since 1970). A picture is finished once its line is.
inline constexpr const char* recording_table = "recording.csv";

/// The finished pictures of a folder, in order, with their times (s); none where it is no recording. Throws
/// InputError where the table is not as it should be.
std::vector<std::pair<std::filesystem::path, double>> recorded_pictures(const std::filesystem::path& folder);

/// What truth.csv may hold beside `source`.
std::vector<std::string> truth_columns();
/// When each of a folder's pictures was taken (s), as its truth.csv says; nothing unless it says so of all,
/// in order.
std::vector<double> times_in_truth(const std::filesystem::path& folder,
                                   const std::vector<std::filesystem::path>& pictures);

/// A picture that is compressed already.
struct CompressedPicture {
  std::shared_ptr<const std::string> png;
  double time_s = 0, captured_unix_s = 0;
};

/// The last pictures, compressed beside whoever gives them; the oldest fall out.
class RecentPictures {
 public:
  static constexpr std::size_t most_bytes = std::size_t{256} << 20;

  explicit RecentPictures(double seconds) : seconds_(seconds) {}
  /// Leaves the picture out while the one before it is still being compressed. Time that goes back begins
  /// anew.
  void put(const cv::Mat& bgr, double time_s, double captured_unix_s);
  const std::deque<CompressedPicture>& pictures() const { return pictures_; }
  double seconds() const;  ///< from the first to the last of them

 private:
  double seconds_;
  std::deque<CompressedPicture> pictures_;
  std::size_t bytes_ = 0;
  std::future<CompressedPicture> compressed_;
};

/// Small files beside a recording's pictures, by name: settings, colours.
using FilesBeside = std::map<std::string, std::string>;

/// Writes a recording, as RecordingWriter makes its folder, of pictures whose tracks nobody has kept.
void write_recording(const std::filesystem::path& folder, Overwrite overwrite,
                     const std::deque<CompressedPicture>& pictures, const FilesBeside& beside);

/// Writes on a thread of its own: who gives pictures never waits for the disk.
class RecordingWriter {
 public:
  /// Makes the folder; one that is there is to be empty, or `overwrite` allows to take an earlier recording's
  /// place. Throws InputError otherwise.
  RecordingWriter(std::filesystem::path folder, Overwrite overwrite);
  /// Writes what was given.
  ~RecordingWriter();
  RecordingWriter(const RecordingWriter&) = delete;
  RecordingWriter& operator=(const RecordingWriter&) = delete;

  /// The file's name that the next picture gets: what its rows call it.
  std::string next_name() const;
  /// False where the disk does not keep up, or has failed: the picture is lost, and counted.
  bool put(const cv::Mat& bgr, double time_s, double captured_unix_s, std::string rows);
  void put_beside(const FilesBeside& files);

  const std::filesystem::path& folder() const { return folder_; }
  long kept() const { return kept_; }
  long lost() const;
  std::string fault() const;  ///< why it has ended; empty while it goes on

 private:
  struct Item {
    cv::Mat bgr;
    std::string name, line, rows;
  };
  void write(const Item& item);

  std::filesystem::path folder_;
  mutable std::mutex mutex_;
  std::size_t bytes_ = 0;
  std::string fault_;
  long kept_ = 0, lost_ = 0;
  boost::asio::thread_pool thread_{1};
};

}  // namespace ballservo
