#include "perception/segmentation/regions.hpp"

#include <algorithm>
#include <array>

namespace ballservo {
namespace {

std::size_t place(int i) { return static_cast<std::size_t>(i); }

constexpr int word_bits = BitPicture::word_bits;

// Of each pixel of a word: whether the four beside it are all set.
std::uint64_t all_beside(const BitPicture& picture, int v, int w) {
  const std::uint64_t* const row = picture.row(v);
  const std::uint64_t left = row[w] << 1 | (w > 0 ? row[w - 1] >> (word_bits - 1) : 0);
  const std::uint64_t right = row[w] >> 1 | (w + 1 < picture.row_words() ? row[w + 1] << (word_bits - 1) : 0);
  return left & right & picture.row(v - 1)[w] & picture.row(v + 1)[w];
}

constexpr int corner_reach = 3;

// The pixels up to three to the left and right of one, from bit 0 on; beyond the border the last one goes on.
unsigned seven_around(const BitPicture& picture, int u, int v) {
  const int width = picture.size().width;
  if (u < corner_reach || u + corner_reach >= width) {
    unsigned bits = 0;
    for (int du = -corner_reach; du <= corner_reach; ++du)
      bits |= static_cast<unsigned>(picture.at(std::clamp(u + du, 0, width - 1), v)) << (du + corner_reach);
    return bits;
  }
  const int w = (u - corner_reach) / word_bits, shift = (u - corner_reach) % word_bits;
  const std::uint64_t* const row = picture.row(v);
  std::uint64_t bits = row[w] >> shift;
  if (shift + 2 * corner_reach >= word_bits) bits |= row[w + 1] << (word_bits - shift);
  return bits & 127;
}

// Calls found(begin, end, class) for each run of a row.
template <class Found>
void for_each_run(const ClassPictures& classes, cv::Size size, int v, const Found& found) {
  const std::size_t count = classes.size();
  std::array<const std::uint64_t*, max_classes> rows;
  for (std::size_t k = 0; k < count; ++k) rows[k] = classes[k].row(v);
  int begin = 0;
  ClassIndex color_class = no_class;
  const int words = count == 0 ? 0 : classes[0].row_words();
  for (int w = 0; w < words; ++w) {
    std::uint64_t changed = 0;  // pixels, in any class, that are of another class than the one to their left
    for (std::size_t k = 0; k < count; ++k) {
      const std::uint64_t left = w > 0 ? rows[k][w - 1] >> (word_bits - 1) : 0;
      changed |= rows[k][w] ^ (rows[k][w] << 1 | left);
    }
    for (; changed != 0; changed &= changed - 1) {
      const int u = word_bits * w + __builtin_ctzll(changed);
      if (u == size.width) break;  // the bits behind the last pixel
      if (u > begin) found(begin, u, color_class);
      begin = u;
      std::size_t k = 0;
      while (k < count && !(rows[k][w] & changed & (0 - changed))) ++k;
      color_class = k < count ? static_cast<ClassIndex>(k + 1) : no_class;
    }
  }
  found(begin, size.width, color_class);
}

void drop_shorter(ClassPictures& classes, cv::Size size, int shortest) {
  for (int v = 0; v < size.height; ++v) {
    for_each_run(classes, size, v, [&](int begin, int end, ClassIndex color_class) {
      if (color_class != no_class && end - begin < shortest)
        classes[static_cast<std::size_t>(color_class) - 1].fill(v, begin, end, false);
    });
  }
}

}  // namespace

bool RegionMap::try_to_cut(cv::Size size, int max_runs) {
  runs_.clear();
  row_begin_.clear();
  for (int v = 0; v < size.height; ++v) {
    row_begin_.push_back(static_cast<int>(runs_.size()));
    for_each_run(classes_, size, v, [&](int begin, int end, ClassIndex color_class) {
      runs_.push_back({v, begin, end, color_class});
    });
    if (static_cast<int>(runs_.size()) > max_runs) return false;
  }
  return true;
}

void RegionMap::cut_runs(cv::Size size) {
  const int max_runs = std::max(max_runs_, size.height);
  runs_.reserve(place(max_runs + size.width));
  row_begin_.reserve(place(size.height));
  for (shortest_run_px_ = 1; !try_to_cut(size, max_runs);) {
    shortest_run_px_ *= 2;
    drop_shorter(classes_, size, shortest_run_px_);
  }
}

void RegionMap::update(const ClassPictures& classes, cv::Size size) {
  classes_ = classes;
  cut_runs(size);
  reserve(runs_.capacity());
  join_runs();
  number_components();
  for (Region& region : regions_) {
    const cv::Rect& box = region.box;
    region.touches_border = box.x == 0 || box.y == 0 || box.br().x == size.width || box.br().y == size.height;
  }
  find_surroundings();
  absorb_enclosed();
  list_runs();
}

// Of n runs, no more than 2 n pairs share an edge between rows, and n in a row.
void RegionMap::reserve(std::size_t runs) {
  for (std::vector<int>* of_runs : {&parent_, &next_run_, &first_run_}) of_runs->reserve(runs);
  regions_.reserve(runs);
  touching_.reserve(3 * runs);
}

int RegionMap::component_of(int run) {
  while (parent_[place(run)] != run) {
    int& up = parent_[place(run)];
    up = parent_[place(up)];
    run = up;
  }
  return run;
}

// Each run joins those of its class that it touches in the row above; a component is named by its first run.
void RegionMap::join_runs() {
  const int count = static_cast<int>(runs_.size());
  parent_.resize(place(count));
  for (int i = 0; i < count; ++i) parent_[place(i)] = i;
  touching_.clear();
  int above = 0;
  for (int i = 0; i < count; ++i) {
    const Run& run = runs_[place(i)];
    const int row_begin = row_begin_[place(run.v)];
    if (i > row_begin) touching_.emplace_back(i - 1, i);
    if (run.v == 0) continue;
    if (i == row_begin) above = row_begin_[place(run.v - 1)];
    while (above < row_begin && runs_[place(above)].end < run.begin) ++above;
    for (int j = above; j < row_begin && runs_[place(j)].begin <= run.end; ++j) {
      const Run& upper = runs_[place(j)];
      const bool edge = upper.begin < run.end && run.begin < upper.end;
      if (upper.color_class != run.color_class) {
        if (edge) touching_.emplace_back(j, i);
      } else if (edge || run.color_class != no_class) {
        const int a = component_of(i), b = component_of(j);
        parent_[place(std::max(a, b))] = std::min(a, b);
      }
    }
  }
}

void RegionMap::number_components() {
  regions_.clear();
  for (std::size_t i = 0; i < runs_.size(); ++i) {
    const Run& run = runs_[i];
    int& region = parent_[i];  // every earlier run's is its region's number by now
    if (place(region) == i) {
      region = static_cast<int>(regions_.size());
      regions_.push_back({});
      regions_.back().color_class = run.color_class;
    } else {
      region = parent_[place(region)];
    }
    Region& whole = regions_[place(region)];
    whole.pixels += run.end - run.begin;
    whole.box |= cv::Rect(run.begin, run.v, run.end - run.begin, 1);
  }
}

// The only region that shares an edge with each one, where there is just one.
void RegionMap::find_surroundings() {
  const auto meet = [&](int region, int other) {
    int& known = regions_[place(region)].only_neighbor;
    known = known == Region::no_neighbor || known == other ? other : Region::several;
  };
  for (const auto& [run_a, run_b] : touching_) {
    const int a = parent_[place(run_a)], b = parent_[place(run_b)];
    meet(a, b);
    meet(b, a);
  }
}

// What a single region of a class encloses belongs to it. What absorbs is never absorbed itself: it has a
// second neighbour, or is the outer one of two.
void RegionMap::absorb_enclosed() {
  for (int i = 0; i < static_cast<int>(regions_.size()); ++i) {
    Region& region = regions_[place(i)];
    if (region.touches_border || region.only_neighbor < 0) continue;
    Region& around = regions_[place(region.only_neighbor)];
    // Two regions can be each other's only neighbour: the larger box is the outer one. A region of another
    // class is absorbed only as a speck, for it may be a ball in front of a larger one.
    const bool speck = region.color_class == no_class || region.pixels * 20 < around.pixels;
    if (!speck || around.color_class == no_class || around.pixels < region.pixels ||
        around.box.area() <= region.box.area()) {
      continue;
    }
    region.absorbed_by = region.only_neighbor;
    around.pixels += region.pixels;
  }
}

void RegionMap::list_runs() {
  first_run_.assign(regions_.size(), -1);
  next_run_.resize(runs_.size());
  for (std::size_t i = runs_.size(); i-- > 0;) {
    int region = parent_[i];
    if (const int absorbed_by = regions_[place(region)].absorbed_by; absorbed_by >= 0) {
      region = absorbed_by;
      const std::size_t k = regions_[place(region)].color_class;
      classes_[k - 1].fill(runs_[i].v, runs_[i].begin, runs_[i].end, true);
    }
    next_run_[i] = first_run_[place(region)];
    first_run_[place(region)] = static_cast<int>(i);
  }
}

// Within a run of the region, the class's pixels are the region's: another region of the class shares no edge
// with it, and whoever is enclosed by it has been absorbed.
void RegionMap::boundary(int region, std::vector<BoundaryPixel>& boundary) const {
  boundary.clear();
  const ClassIndex color_class = regions_[place(region)].color_class;
  if (color_class == no_class) return;
  const BitPicture& picture = pixels_of(color_class);
  const int last_u = picture.size().width - 1, last_v = picture.size().height - 1;
  for (int i = first_run_[place(region)]; i >= 0; i = next_run_[place(i)]) {
    const Run& run = runs_[place(i)];
    if (run.v == 0 || run.v == last_v) continue;
    const int begin = std::max(run.begin, 1), end = std::min(run.end, last_u);
    for (int w = begin / word_bits; w * word_bits < end; ++w) {
      const int first = w * word_bits;
      std::uint64_t found = ~all_beside(picture, run.v, w) & BitPicture::bits_from(begin - first) &
                            ~BitPicture::bits_from(end - first);
      for (; found != 0; found &= found - 1)
        boundary.push_back({first + __builtin_ctzll(found), run.v, {0, 0}});
    }
  }
}

Eigen::Vector2f outward_normal(const BitPicture& colored, const BoundaryPixel& pixel) {
  int sum_u = 0, sum_v = 0;
  for (int dv = -corner_reach; dv <= corner_reach; ++dv) {
    const int v = std::clamp(pixel.v_px + dv, 0, colored.size().height - 1);
    const unsigned bits = seven_around(colored, pixel.u_px, v);
    const auto has = [bits](int du) { return static_cast<int>(bits >> (corner_reach + du) & 1); };
    for (int du = 1; du <= corner_reach; ++du) sum_u += du * (has(du) - has(-du));
    sum_v += dv * __builtin_popcount(bits);
  }
  if (sum_u == 0 && sum_v == 0) return {0, 0};
  return -Eigen::Vector2f(static_cast<float>(sum_u), static_cast<float>(sum_v)).normalized();
}

int choose_regions(const std::vector<Region>& regions, double min_pixels, int max_regions,
                   std::vector<int>& chosen) {
  chosen.clear();
  for (std::size_t i = 0; i < regions.size(); ++i) {
    if (regions[i].color_class != no_class && regions[i].absorbed_by < 0 && regions[i].pixels >= min_pixels)
      chosen.push_back(static_cast<int>(i));
  }
  const int left_out = static_cast<int>(chosen.size()) - max_regions;
  if (left_out <= 0) return 0;
  std::nth_element(chosen.begin(), chosen.begin() + max_regions, chosen.end(), [&](int a, int b) {
    const int pixels_a = regions[place(a)].pixels, pixels_b = regions[place(b)].pixels;
    return pixels_a != pixels_b ? pixels_a > pixels_b : a < b;
  });
  chosen.resize(place(max_regions));
  std::sort(chosen.begin(), chosen.end());
  return left_out;
}

}  // namespace ballservo
