#include "app/io/video_writer.hpp"

#include <cmath>

#include "calibration/base/fault.hpp"

namespace ballservo {

VideoFile::VideoFile(const std::filesystem::path& target, Overwrite overwrite, double fps)
    : file_(target, overwrite), fps_(fps) {
  const std::string extension = target.extension().string();
  exact_ = extension == ".mkv";
  if (!exact_ && extension != ".mp4")
    throw InputError(target.string(), "a video named '" + extension + "'",
                     ".mp4 (H.264) or .mkv (FFV1, bit exact)");
}

// FFmpeg takes no absolute path for an address.
std::string VideoFile::place() const { return std::filesystem::absolute(file_.staging_path()).string(); }

void VideoFile::write(const cv::Mat& bgr) {
  if (!writer_.isOpened()) {
    const cv::Size size(bgr.cols & ~1, bgr.rows & ~1);
    const int codec =
        exact_ ? cv::VideoWriter::fourcc('F', 'F', 'V', '1') : cv::VideoWriter::fourcc('a', 'v', 'c', '1');
    if (!writer_.open(place(), cv::CAP_FFMPEG, codec, fps_, exact_ ? bgr.size() : size)) {
      throw InputError(file_.target().string(), "a video that cannot be opened for writing",
                       "a folder with room, and OpenCV with FFmpeg");
    }
  }
  ++written_;
  writer_.write(exact_ ? bgr : bgr(cv::Rect(0, 0, bgr.cols & ~1, bgr.rows & ~1)));
}

void VideoFile::commit() {
  if (!writer_.isOpened()) return;
  writer_.release();
  // OpenCV's writer says nothing of a full disk: what it leaves then does not open, or tells no length.
  const cv::VideoCapture film(place(), cv::CAP_FFMPEG);
  if (!film.isOpened() || std::abs(film.get(cv::CAP_PROP_FRAME_COUNT) - written_) > 1) {
    throw InputError(file_.target().string(), "a video that could not be written whole",
                     "a disk with room for it");
  }
  file_.commit();
}

}  // namespace ballservo
