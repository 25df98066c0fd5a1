#include "calibration/color/class_table.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace ballservo {
namespace {

constexpr float fringe_share =
    0.25f;  // background as dense as that part of the ball takes a cell of the fringe ...
constexpr float core_share = 3.0f;  // ... and as dense as that many times the ball, one of the core
// What a cell's 2-D density says of its density in 3-D, where the ball was not seen at that lightness: four
// cells of the one make a cell of the other, and a ball's shades spread over some eight cells of lightness.
constexpr float unseen_share = 0.5f;

/// Smooths along one axis of a grid by the binomial kernel (1, 2, 1) / 4.
void smooth(std::vector<float>& values, int stride, int length) {
  const std::vector<float> before = values;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const int position = static_cast<int>(i) / stride % length;
    const float low = position > 0 ? before[i - stride] : 0.0f;
    const float high = position + 1 < length ? before[i + stride] : 0.0f;
    values[i] = 0.25f * low + 0.5f * before[i] + 0.25f * high;
  }
}

void normalise(std::vector<float>& values) {
  double total = 0;
  for (const float value : values) total += value;
  if (total <= 0) return;
  for (float& value : values) value = static_cast<float>(value / total);
}

/// A smoothed density over coarse cells of (L, a, b).
class LabDensity {
 public:
  LabDensity() : values_(static_cast<std::size_t>(chroma_bins * chroma_bins * lightness_bins), 0.0f) {}

  void add(const Eigen::Vector3f& lab, float weight) { values_[bin(lab)] += weight; }

  void finish() {
    smooth(values_, 1, chroma_bins);
    smooth(values_, chroma_bins, chroma_bins);
    smooth(values_, chroma_bins * chroma_bins, lightness_bins);
    normalise(values_);
  }

  float at(const Eigen::Vector3f& lab) const { return values_[bin(lab)]; }

 private:
  static constexpr int chroma_bins = 64, lightness_bins = 13;
  static constexpr float chroma_width = 4, lightness_width = 8;

  static std::size_t bin(const Eigen::Vector3f& lab) {
    const auto cell = [](float v, int bins) {
      return std::clamp(static_cast<int>(std::floor(v)), 0, bins - 1);
    };
    const int l = cell(lab.x() / lightness_width, lightness_bins);
    const int a = cell(lab.y() / chroma_width + chroma_bins / 2, chroma_bins);
    const int b = cell(lab.z() / chroma_width + chroma_bins / 2, chroma_bins);
    return static_cast<std::size_t>((l * chroma_bins + b) * chroma_bins + a);
  }

  std::vector<float> values_;
};

/// A class's smoothed density over the cells of the table.
std::vector<float> cell_density(const ColorSamples& samples) {
  std::vector<float> result(ColorTable::entries, 0.0f);
  for (const ColorSamples::Pixel& pixel : samples.pixels) result[pixel.table_cell] += 1;
  for (int axis = 0, stride = 1; axis < 3; ++axis, stride *= ColorTable::side)
    smooth(result, stride, ColorTable::side);
  normalise(result);
  return result;
}

}  // namespace

std::vector<ClassIndex> class_table(const std::vector<ClassEvidence>& classes, const CellCounts& background,
                                    const SampleOptions& options) {
  options.validate();
  const std::vector<Eigen::Vector3f> colors = table_cell_colors();
  LabDensity elsewhere;
  for (std::size_t i = 0; i < background.size(); ++i) {
    if (background[i] > 0) elsewhere.add(colors[i], static_cast<float>(background[i]));
  }
  elsewhere.finish();
  std::vector<LabDensity> on_ball(classes.size());
  std::vector<std::vector<float>> in_cells;
  for (std::size_t k = 0; k < classes.size(); ++k) {
    for (const ColorSamples::Pixel& pixel : classes[k].samples.pixels)
      on_ball[k].add(colors[pixel.table_cell], 1);
    on_ball[k].finish();
    in_cells.push_back(cell_density(classes[k].samples));
  }

  std::vector<ClassIndex> table(ColorTable::entries, no_class);
  for (int i = 0; i < ColorTable::entries; ++i) {
    if (!options.has_color(colors[i].cast<double>())) continue;
    const int cell = chroma_cell(colors[i].y(), colors[i].z());
    const int row = cell / ChromaHistogram::side, column = cell % ChromaHistogram::side;
    float best = 0, best_seen = 0;
    for (std::size_t k = 0; k < classes.size(); ++k) {
      const float density = classes[k].group.density(row, column);
      if (density <= 0) continue;
      const float seen = in_cells[k][i];
      if (seen < best_seen || (seen == best_seen && density <= best)) continue;
      best = density;
      best_seen = seen;
      table[i] = static_cast<ClassIndex>(k + 1);
    }
    if (table[i] == no_class) continue;
    const std::size_t k = table[i] - 1u;
    const ChromaGroup& group = classes[k].group;
    const float ball = std::max(on_ball[k].at(colors[i]), unseen_share * group.density(row, column));
    if (elsewhere.at(colors[i]) > (group.core(row, column) ? core_share : fringe_share) * ball)
      table[i] = no_class;
  }
  return table;
}

}  // namespace ballservo
