#include "app/io/board_pictures.hpp"

#include <fmt/format.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <map>
#include <mutex>

#include "app/io/image_source.hpp"
#include "app/io/interrupt.hpp"
#include "app/io/progress.hpp"
#include "calibration/base/fault.hpp"
#include "calibration/base/system_file.hpp"
#include "calibration/boards/board_detector.hpp"
#include "calibration/pictures/image_file.hpp"

namespace ballservo {
namespace {

constexpr int max_size_difference_px = 2;
constexpr std::size_t most_moving_pictures = 40;
constexpr double most_camera_s = 120;
constexpr double least_motion = 0.04;  // of the picture's width, between two pictures of a moving board

using GridSize = std::pair<int, int>;

std::string size_text(ImageSize size) { return fmt::format("{}x{}", size.width_px, size.height_px); }

/// A remark after those that are there already.
void add_remark(BoardPicture& picture, const std::string& remark) {
  picture.remark += (picture.remark.empty() ? "" : "; ") + remark;
}

void search_in(BoardPicture& picture, const BoardSearch& search) {
  const cv::Mat image = picture.picture(search.max_pixels);
  picture.size = ImageSize{image.cols, image.rows};
  BoardFinding finding = find_board(image, search.board);
  picture.view = std::move(finding.view);
  picture.seen = finding.seen;
  picture.rejected = std::move(finding.reason);
  if (!picture.view) return;
  picture.view->name = std::filesystem::path(picture.name()).filename().string();
  const std::size_t all = search.board.points().size();
  if (picture.view->size() < all)
    add_remark(picture, fmt::format("{} of the board's {} corners are seen", picture.view->size(), all));
}

/// The sizes of all pictures before any is decoded; every file that cannot be read is a fault.
std::vector<BoardPicture> list_pictures(const std::vector<std::string>& sources, const BoardSearch& search) {
  std::vector<BoardPicture> pictures;
  FaultList faults;
  for (const SourceFile& file : source_files(sources)) {
    faults.collect([&] {
      if (file.kind != SourceFile::Kind::image) {
        const auto sequence = std::move(open_sources({file.path.string()}, 30, search.max_pixels).front());
        for (BoardPicture& picture : pictures_of_moving_board(*sequence, file, search))
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

std::vector<BoardPicture> list_stills(const std::vector<cv::Mat>& stills, const BoardSearch& search) {
  std::vector<BoardPicture> pictures(stills.size());
  FaultList faults;
  for (std::size_t k = 0; k < stills.size(); ++k) {
    BoardPicture& picture = pictures[k];
    picture.file = fmt::format("picture {}", k + 1);
    picture.decoded = stills[k];
    picture.size = ImageSize{stills[k].cols, stills[k].rows};
    if (static_cast<double>(stills[k].cols) * stills[k].rows > search.max_pixels)
      faults.add(picture.file.string(), "a picture of " + size_text(*picture.size),
                 fmt::format("at most {:.0f} pixels", search.max_pixels));
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
    else if (picture.view)
      add_remark(picture,
                 fmt::format("it is {}, the others are {}: used as it stands, from the top-left pixel on",
                             size_text(*picture.size), size_text(common)));
  }
  faults.throw_if_any();
  return common;
}

/// Refusal where most of the chessboards seen agree on another size than the one named: a larger one, or a
/// smaller one while none shows the one named.
void require_board_size(const std::vector<BoardPicture>& pictures, const BoardSearch& search) {
  const GridSize named(std::max(search.board.columns, search.board.rows),
                       std::min(search.board.columns, search.board.rows));
  std::map<GridSize, std::size_t> votes;
  std::size_t seen = 0;
  for (const BoardPicture& picture : pictures)
    if (picture.seen) ++votes[*picture.seen], ++seen;
  for (const auto& [size, count] : votes) {
    const bool larger = size != named && size.first >= named.first && size.second >= named.second;
    if (size == named || 2 * count <= seen || (!larger && votes.count(named) > 0)) continue;
    throw Refusal(
        fmt::format("The pictures show a chessboard of {0}x{1} inner corners, not {2}. If {0}x{1} is right, "
                    "give --board chessboard:{0}x{1}, and measure --square once more.",
                    size.first, size.second, search.board_text.substr(search.board_text.find(':') + 1)));
  }
}

/// Sets aside pictures whose board stands exactly as in an earlier one: the same picture twice is no new
/// evidence, but would count as such.
void drop_repeated(std::vector<BoardPicture>& pictures) {
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    for (std::size_t k = 0; k < i && pictures[i].view; ++k) {
      if (!pictures[k].view || pictures[k].view->corners_px != pictures[i].view->corners_px) continue;
      pictures[i].view.reset();
      pictures[i].rejected = "it is the same picture as " + pictures[k].name();
    }
  }
}

BoardPictures find_boards_in(std::vector<BoardPicture> listed, const BoardSearch& search) {
  BoardPictures pictures{std::move(listed), {}};
  common_size(pictures.all);
  std::vector<FaultList> faults_of(pictures.all.size());
  Progress progress("looking for the board", static_cast<long>(pictures.all.size()), search.quiet);
  std::mutex progress_mutex;
  long done = 0;
  tbb::task_arena arena(search.threads > 0 ? search.threads : tbb::task_arena::automatic);
  arena.execute([&] {
    tbb::parallel_for(std::size_t{0}, pictures.all.size(), [&](std::size_t i) {
      BoardPicture& picture = pictures.all[i];
      if (interrupt_requested()) return;
      faults_of[i].collect([&] {
        if (!picture.view && picture.rejected.empty()) search_in(picture, search);
      });
      const std::lock_guard lock(progress_mutex);
      progress.step(++done);
    });
  });
  throw_if_interrupted();
  FaultList faults;
  for (const FaultList& each : faults_of) faults.collect([&] { each.throw_if_any(); });
  faults.throw_if_any();
  pictures.size = common_size(pictures.all);
  drop_repeated(pictures.all);
  require_board_size(pictures.all, search);
  if (pictures.used().empty())
    throw Refusal(fmt::format(
        "The board {} was not found in any picture ({} looked at). Are {} its inner corners (or circle "
        "centres)? Is the whole board in each picture, with a white margin around it, sharp and evenly lit? "
        "(An asymmetric grid of circles is not found in mirrored pictures.)",
        search.board_text, pictures.all.size(), search.board_text.substr(search.board_text.find(':') + 1)));
  return pictures;
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

std::vector<BoardPicture> pictures_of_moving_board(FrameSequence& sequence, const SourceFile& source,
                                                   const BoardSearch& search) {
  std::vector<BoardPicture> taken;
  const bool is_camera = source.kind == SourceFile::Kind::camera;
  Progress progress(is_camera ? "places of the board" : source.path.filename().string(),
                    is_camera ? static_cast<long>(most_moving_pictures) : sequence.length(), search.quiet);
  constexpr int step = 5;  // neighbouring pictures are alike
  std::optional<GridSize> last_seen;
  while (auto frame = taken.size() < most_moving_pictures ? sequence.next() : std::nullopt) {
    throw_if_interrupted();
    progress.step(is_camera ? static_cast<long>(taken.size()) : frame->index + 1);
    if (is_camera && frame->time_s > most_camera_s) break;
    if (frame->index % step != 0) continue;
    BoardPicture picture;
    picture.file = source.path;
    picture.frame = frame->index;
    picture.decoded = frame->bgr;
    search_in(picture, search);
    last_seen = picture.seen ? picture.seen : last_seen;
    if (!picture.view) continue;
    const bool is_new = std::all_of(taken.begin(), taken.end(), [&](const BoardPicture& other) {
      return mean_motion_px(*picture.view, *other.view) > least_motion * frame->bgr.cols;
    });
    if (is_new) taken.push_back(std::move(picture));
  }
  if (taken.empty()) {
    BoardPicture& none = taken.emplace_back();
    none.file = source.path;
    none.seen = last_seen;
    none.rejected = "the board was found in none of its pictures";
  }
  return taken;
}

BoardPictures find_boards(const std::vector<std::string>& sources, const BoardSearch& search) {
  return find_boards_in(list_pictures(sources, search), search);
}

BoardPictures find_boards(const std::vector<cv::Mat>& stills, const BoardSearch& search) {
  return find_boards_in(list_stills(stills, search), search);
}

}  // namespace ballservo
