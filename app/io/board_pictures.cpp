#include "app/io/board_pictures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <map>
#include <mutex>
#include <thread>

#include "app/io/image_source.hpp"
#include "app/io/interrupt.hpp"
#include "app/io/progress.hpp"
#include "calibration/camera/board_detector.hpp"
#include "calibration/files/fault.hpp"
#include "calibration/files/image_file.hpp"

namespace ballservo {
namespace {

constexpr int max_size_difference_px = 2;
constexpr std::size_t max_video_pictures = 40;
constexpr double least_motion = 0.04;  // of the picture's width, between two pictures taken from a video
constexpr int looked_at_for_size = 3;  // pictures whose chessboard is measured, whatever size was named

using GridSize = std::pair<int, int>;

/// What one picture's search brought, beside the picture itself.
struct Found {
  std::exception_ptr error;
  std::optional<GridSize> size;  // of the chessboard that is seen
};

std::string size_text(ImageSize size) { return fmt::format("{}x{}", size.width_px, size.height_px); }

void search_in(BoardPicture& picture, Found& found, const BoardSearch& search, bool measure) {
  try {
    const cv::Mat image = picture.picture(search.max_pixels);
    picture.size = ImageSize{image.cols, image.rows};
    BoardFinding finding = find_board(image, search.board);
    picture.view = std::move(finding.view);
    picture.rejected = std::move(finding.reason);
    if (picture.view) picture.view->name = std::filesystem::path(picture.name()).filename().string();
    found.size = finding.seen;
    // A board of the size named may be a part of a larger one.
    if (picture.view && measure) found.size = std::max(finding.seen, chessboard_size(image, search.board));
    if (picture.view && picture.view->size() < search.board.points().size())
      picture.remark = fmt::format("{} of the board's {} corners are seen", picture.view->size(),
                                   search.board.points().size());
  } catch (...) {
    found.error = std::current_exception();
  }
}

/// Does `work(i)` for every i below `count`, several at a time.
template <class Work>
void in_parallel(std::size_t count, int threads, const Work& work) {
  std::atomic<std::size_t> next{0};
  const auto worker = [&] {
    for (std::size_t i = next++; i < count && !interrupt_requested(); i = next++) work(i);
  };
  const std::size_t wanted =
      threads > 0 ? static_cast<std::size_t>(threads) : std::max(1u, std::thread::hardware_concurrency());
  std::vector<std::thread> workers;
  for (std::size_t i = 1; i < std::min(wanted, count); ++i) workers.emplace_back(worker);
  worker();
  for (std::thread& thread : workers) thread.join();
  throw_if_interrupted();
}

double mean_motion_px(const BoardView& a, const BoardView& b) {
  const std::size_t count = std::min(a.size(), b.size());
  double sum = 0;
  for (std::size_t i = 0; i < count; ++i) sum += (a.corners_px[i] - b.corners_px[i]).norm();
  return sum / static_cast<double>(count);
}

/// The pictures of a video in which the board stands elsewhere than in those taken before.
std::vector<BoardPicture> video_pictures(const std::filesystem::path& file, const BoardSearch& search) {
  std::vector<BoardPicture> taken;
  const auto sequence = std::move(open_sources({file.string()}, 30, search.max_pixels).front());
  Progress progress(file.filename().string(), sequence->length(), search.quiet);
  constexpr int step = 5;  // neighbouring pictures are alike
  while (auto frame = sequence->next()) {
    throw_if_interrupted();
    progress.step(frame->index + 1);
    if (frame->index % step != 0 || taken.size() == max_video_pictures) continue;
    BoardPicture picture;
    picture.file = file;
    picture.frame = frame->index;
    picture.decoded = frame->bgr;
    Found found;
    search_in(picture, found, search, false);
    if (found.error) std::rethrow_exception(found.error);
    if (!picture.view) continue;
    const bool is_new = std::all_of(taken.begin(), taken.end(), [&](const BoardPicture& other) {
      return mean_motion_px(*picture.view, *other.view) > least_motion * frame->bgr.cols;
    });
    if (is_new) taken.push_back(std::move(picture));
  }
  if (taken.empty()) {
    BoardPicture& none = taken.emplace_back();
    none.file = file;
    none.rejected = "the board was found in none of its pictures";
  }
  return taken;
}

/// The sizes of all pictures before any is decoded; every file that cannot be read is a fault.
std::vector<BoardPicture> list_pictures(const std::vector<std::string>& sources, const BoardSearch& search) {
  std::vector<BoardPicture> pictures;
  FaultList faults;
  for (const SourceFile& file : image_and_video_files(sources)) {
    faults.collect([&] {
      if (file.is_video) {
        for (BoardPicture& picture : video_pictures(file.path, search))
          pictures.push_back(std::move(picture));
        return;
      }
      BoardPicture& picture = pictures.emplace_back();
      picture.file = file.path;
      picture.size = image_size_from_header(read_file_bytes(file.path, std::size_t{1} << 30));
    });
  }
  faults.throw_if_any();
  return pictures;
}

ImageSize common_size(std::vector<BoardPicture>& pictures) {
  std::map<std::pair<int, int>, int> counts;
  ImageSize common;
  int most = 0;
  for (const BoardPicture& picture : pictures)
    if (picture.size) ++counts[{picture.size->width_px, picture.size->height_px}];
  for (const BoardPicture& picture : pictures) {
    if (!picture.size) continue;
    const int count = counts[{picture.size->width_px, picture.size->height_px}];
    if (count > most) most = count, common = *picture.size;
  }
  FaultList faults;
  for (BoardPicture& picture : pictures) {
    if (!picture.size || *picture.size == common) continue;
    const int off = std::max(std::abs(picture.size->width_px - common.width_px),
                             std::abs(picture.size->height_px - common.height_px));
    if (off > max_size_difference_px)
      faults.add(picture.file.string(), "a picture of " + size_text(*picture.size),
                 "one of " + size_text(common) + ", as most have: all pictures come from one camera");
    else
      picture.remark =
          fmt::format("it is {}, the others are {}: used as it stands, from the top-left pixel on",
                      size_text(*picture.size), size_text(common));
  }
  faults.throw_if_any();
  return common;
}

/// Refusal where the chessboards seen agree on another size than the one named: a larger one in most of the
/// pictures measured, or a smaller one in most of all while none shows the one named.
void require_board_size(const std::vector<Found>& found, const BoardSearch& search) {
  const GridSize named(std::max(search.board.columns, search.board.rows),
                       std::min(search.board.columns, search.board.rows));
  const std::size_t measured = std::min<std::size_t>(looked_at_for_size, found.size());
  std::map<GridSize, std::size_t> among_measured, among_all;
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (!found[i].size) continue;
    ++among_all[*found[i].size];
    if (i < measured) ++among_measured[*found[i].size];
  }
  for (const auto& [size, count] : among_all) {
    if (size == named) continue;
    const bool larger =
        size.first >= named.first && size.second >= named.second && 2 * among_measured[size] > measured;
    const bool instead = among_all.count(named) == 0 && 2 * count > found.size();
    if (!larger && !instead) continue;
    throw Refusal(fmt::format(
        "The pictures show a chessboard of {0}x{1} inner corners, not {2}. If {0}x{1} is right, give --board "
        "chessboard:{0}x{1}, and measure --square once more.",
        size.first, size.second, search.board_text.substr(search.board_text.find(':') + 1)));
  }
}

}  // namespace

std::string BoardPicture::name() const {
  return frame < 0 ? file.string() : fmt::format("{} frame {}", file.string(), frame);
}

cv::Mat BoardPicture::picture(double max_pixels) const {
  return decoded.empty() ? read_color_image(file, max_pixels) : decoded;
}

std::vector<const BoardPicture*> BoardPictures::used() const {
  std::vector<const BoardPicture*> result;
  for (const BoardPicture& picture : all)
    if (picture.view && picture.rejected.empty()) result.push_back(&picture);
  return result;
}

BoardPictures find_boards(const std::vector<std::string>& sources, const BoardSearch& search) {
  BoardPictures pictures{list_pictures(sources, search), {}};
  common_size(pictures.all);
  std::vector<Found> found(pictures.all.size());
  Progress progress("looking for the board", static_cast<long>(pictures.all.size()), search.quiet);
  std::mutex progress_mutex;
  long done = 0;
  in_parallel(pictures.all.size(), search.threads, [&](std::size_t i) {
    if (!pictures.all[i].view && pictures.all[i].rejected.empty())
      search_in(pictures.all[i], found[i], search, i < looked_at_for_size);
    const std::lock_guard<std::mutex> lock(progress_mutex);
    progress.step(++done);
  });
  FaultList faults;
  for (const Found& one : found) {
    faults.collect([&] {
      if (one.error) std::rethrow_exception(one.error);
    });
  }
  faults.throw_if_any();
  pictures.size = common_size(pictures.all);
  require_board_size(found, search);
  if (pictures.used().empty())
    throw Refusal(fmt::format(
        "The board {} was not found in any picture ({} looked at). Are {} its inner corners (or circle "
        "centres)? Is the whole board in each picture, with a white margin around it, sharp and evenly lit? "
        "(An asymmetric grid of circles is not found in mirrored pictures.)",
        search.board_text, pictures.all.size(), search.board_text.substr(search.board_text.find(':') + 1)));
  return pictures;
}

}  // namespace ballservo
