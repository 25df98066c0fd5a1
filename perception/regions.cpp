#include "perception/regions.hpp"

#include <algorithm>
#include <array>

namespace ballservo {

int RegionMap::find(int component) {
  auto& parent = parent_;
  while (parent[static_cast<std::size_t>(component)] != component) {
    int& up = parent[static_cast<std::size_t>(component)];
    up = parent[static_cast<std::size_t>(up)];
    component = up;
  }
  return component;
}

void RegionMap::update(const cv::Mat& classes) {
  CV_Assert(classes.type() == CV_8UC1);
  runs_.clear();
  parent_.clear();
  touching_.clear();
  regions_.clear();

  // Runs of equal class, row by row; each joins the runs of its class that it touches in the row above.
  std::vector<std::size_t> row_begin(static_cast<std::size_t>(classes.rows) + 1);
  for (int v = 0; v < classes.rows; ++v) {
    row_begin[static_cast<std::size_t>(v)] = runs_.size();
    const ClassIndex* row = classes.ptr<ClassIndex>(v);
    for (int begin = 0; begin < classes.cols;) {
      int end = begin + 1;
      while (end < classes.cols && row[end] == row[begin]) ++end;
      const int component = static_cast<int>(parent_.size());
      parent_.push_back(component);
      runs_.push_back({begin, end, component, row[begin]});
      begin = end;
    }
    row_begin[static_cast<std::size_t>(v) + 1] = runs_.size();
    if (v == 0) continue;
    std::size_t above = row_begin[static_cast<std::size_t>(v) - 1];
    const std::size_t above_end = row_begin[static_cast<std::size_t>(v)];
    for (std::size_t i = above_end; i < runs_.size(); ++i) {
      const Run& run = runs_[i];
      while (above < above_end && runs_[above].end < run.begin) ++above;
      for (std::size_t j = above; j < above_end && runs_[j].begin <= run.end; ++j) {
        const bool overlap = runs_[j].begin < run.end && run.begin < runs_[j].end;
        const bool joined =
            runs_[j].color_class == run.color_class && (overlap || run.color_class != no_class);
        if (joined) {
          const int a = find(run.component), b = find(runs_[j].component);
          parent_[static_cast<std::size_t>(std::max(a, b))] = std::min(a, b);
        }
      }
    }
  }

  // Number the components in raster order, gather their figures, paint them.
  std::vector<int> number(parent_.size(), -1);
  labels_.create(classes.size());
  for (int v = 0; v < classes.rows; ++v) {
    int* labels = labels_[v];
    for (std::size_t i = row_begin[static_cast<std::size_t>(v)];
         i < row_begin[static_cast<std::size_t>(v) + 1]; ++i) {
      Run& run = runs_[i];
      int& label = number[static_cast<std::size_t>(find(run.component))];
      if (label < 0) {
        label = static_cast<int>(regions_.size());
        regions_.push_back({});
        regions_.back().color_class = run.color_class;
      }
      run.component = label;
      Region& region = regions_[static_cast<std::size_t>(label)];
      region.pixels += run.end - run.begin;
      region.box |= cv::Rect(run.begin, v, run.end - run.begin, 1);
      region.touches_border |= v == 0 || v == classes.rows - 1 || run.begin == 0 || run.end == classes.cols;
      std::fill(labels + run.begin, labels + run.end, label);
    }
  }

  // Neighbours: consecutive runs of a row, and overlapping runs of consecutive rows.
  const auto touch = [this](const Run& a, const Run& b) {
    if (a.component != b.component) {
      touching_.emplace_back(a.component, b.component);
      touching_.emplace_back(b.component, a.component);
    }
  };
  for (int v = 0; v < classes.rows; ++v) {
    const std::size_t begin = row_begin[static_cast<std::size_t>(v)],
                      end = row_begin[static_cast<std::size_t>(v) + 1];
    for (std::size_t i = begin; i + 1 < end; ++i) touch(runs_[i], runs_[i + 1]);
    if (v == 0) continue;
    std::size_t j = row_begin[static_cast<std::size_t>(v) - 1];
    for (std::size_t i = begin; i < end; ++i) {
      while (runs_[j].end <= runs_[i].begin) ++j;
      for (std::size_t k = j; k < begin && runs_[k].begin < runs_[i].end; ++k) touch(runs_[i], runs_[k]);
    }
  }
  std::sort(touching_.begin(), touching_.end());
  touching_.erase(std::unique(touching_.begin(), touching_.end()), touching_.end());
  for (const auto& [a, b] : touching_) regions_[static_cast<std::size_t>(a)].neighbors.push_back(b);

  // What a single region of a class encloses belongs to it.
  root_.resize(regions_.size());
  for (std::size_t i = 0; i < regions_.size(); ++i) {
    Region& region = regions_[i];
    root_[i] = static_cast<int>(i);
    if (region.touches_border || region.neighbors.size() != 1) continue;
    Region& around = regions_[static_cast<std::size_t>(region.neighbors[0])];
    // Two regions can be each other's only neighbour: the larger box is the outer one. A region of another
    // class is absorbed only as a speck, for it may be a ball in front of a larger one.
    const bool speck = region.color_class == no_class || region.pixels * 20 < around.pixels;
    if (!speck || around.color_class == no_class || around.pixels < region.pixels ||
        around.box.area() <= region.box.area()) {
      continue;
    }
    region.absorbed_by = region.neighbors[0];
    root_[i] = region.absorbed_by;
    around.pixels += region.pixels;
  }
  for (int& root : root_) {
    while (regions_[static_cast<std::size_t>(root)].absorbed_by >= 0)
      root = regions_[static_cast<std::size_t>(root)].absorbed_by;
  }
}

void RegionMap::boundary(int region, std::vector<BoundaryPixel>& boundary) const {
  boundary.clear();
  const cv::Rect& box = regions_[static_cast<std::size_t>(region)].box;
  static constexpr std::array<std::array<int, 2>, 4> steps{{{1, 0}, {-1, 0}, {0, 1}, {0, -1}}};
  for (int v = std::max(box.y, 1); v < std::min(box.br().y, labels_.rows - 1); ++v) {
    for (int u = std::max(box.x, 1); u < std::min(box.br().x, labels_.cols - 1); ++u) {
      if (region_at(u, v) != region) continue;
      Eigen::Vector2f outward(0, 0);
      bool is_boundary = false;
      for (const auto& [du, dv] : steps) {
        if (region_at(u + du, v + dv) == region) continue;
        is_boundary = true;
        outward += Eigen::Vector2f(static_cast<float>(du), static_cast<float>(dv));
      }
      if (!is_boundary) continue;
      const float length = outward.norm();
      if (length > 0) outward /= length;
      boundary.push_back({u, v, outward});
    }
  }
}

Eigen::Vector2f outward_normal(const cv::Mat& classes, const BoundaryPixel& pixel) {
  const ClassIndex color_class = classes.at<ClassIndex>(pixel.v_px, pixel.u_px);
  int sum_u = 0, sum_v = 0;
  for (int dv = -3; dv <= 3; ++dv) {
    const int v = std::clamp(pixel.v_px + dv, 0, classes.rows - 1);
    const ClassIndex* row = classes.ptr<ClassIndex>(v);
    for (int du = -3; du <= 3; ++du) {
      const int u = std::clamp(pixel.u_px + du, 0, classes.cols - 1);
      if (row[u] == color_class) sum_u += du, sum_v += dv;
    }
  }
  if (sum_u == 0 && sum_v == 0) return {0, 0};
  return -Eigen::Vector2f(static_cast<float>(sum_u), static_cast<float>(sum_v)).normalized();
}

}  // namespace ballservo
