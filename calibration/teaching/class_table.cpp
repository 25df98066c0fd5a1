#include "calibration/teaching/class_table.hpp"

#include <algorithm>
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
  for (std::size_t block = 0; block < values.size(); block += static_cast<std::size_t>(stride) * length) {
    for (int line = 0; line < stride; ++line) {
      float before = 0;
      for (int i = 0; i < length; ++i) {
        float& value = values[block + line + static_cast<std::size_t>(i) * stride];
        const float own = value, after = i + 1 < length ? *(&value + stride) : 0.0f;
        value = 0.25f * before + 0.5f * own + 0.25f * after;
        before = own;
      }
    }
  }
}

void normalise(std::vector<float>& values) {
  double total = 0;
  for (const float value : values) total += value;
  if (total <= 0) return;
  for (float& value : values) value = static_cast<float>(value / total);
}

// Coarse cells of (L, a, b).
constexpr int chroma_bins = 64, lightness_bins = 13;
constexpr float chroma_width = 4, lightness_width = 8;

std::size_t lab_bin(const Eigen::Vector3f& lab) {
  const auto cell = [](float v, int bins) {
    return std::clamp(static_cast<int>(std::floor(v)), 0, bins - 1);
  };
  const int l = cell(lab.x() / lightness_width, lightness_bins);
  const int a = cell(lab.y() / chroma_width + chroma_bins / 2, chroma_bins);
  const int b = cell(lab.z() / chroma_width + chroma_bins / 2, chroma_bins);
  return static_cast<std::size_t>((l * chroma_bins + b) * chroma_bins + a);
}

/// As lab_density, over the cells of the table.
std::vector<float> cell_density(const OccupiedCells& cells) {
  std::vector<float> result(ColorTable::entries, 0.0f);
  for (const CellCount& cell : cells) result[cell.cell] = static_cast<float>(cell.count);
  for (int axis = 0, stride = 1; axis < 3; ++axis, stride *= ColorTable::side)
    smooth(result, stride, ColorTable::side);
  normalise(result);
  return result;
}

}  // namespace

std::vector<float> lab_density(const OccupiedCells& cells) {
  const std::vector<Eigen::Vector3f>& colors = table_cell_colors();
  std::vector<float> result(static_cast<std::size_t>(chroma_bins * chroma_bins * lightness_bins), 0.0f);
  for (const CellCount& cell : cells) result[lab_bin(colors[cell.cell])] += static_cast<float>(cell.count);
  smooth(result, 1, chroma_bins);
  smooth(result, chroma_bins, chroma_bins);
  smooth(result, chroma_bins * chroma_bins, lightness_bins);
  normalise(result);
  return result;
}

double common_area(const std::vector<float>& a, const std::vector<float>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += std::min(a[i], b[i]);
  return sum;
}

std::vector<ClassIndex> class_table(const std::vector<ClassEvidence>& classes,
                                    const OccupiedCells& background) {
  const std::vector<Eigen::Vector3f>& colors = table_cell_colors();
  const std::vector<float> elsewhere = lab_density(background);
  std::vector<std::vector<float>> on_ball, in_cells;
  for (const ClassEvidence& evidence : classes) {
    on_ball.push_back(lab_density(evidence.cells));
    in_cells.push_back(cell_density(evidence.cells));
  }

  std::vector<ClassIndex> table(ColorTable::entries, no_class);
  for (int i = 0; i < ColorTable::entries; ++i) {
    if (!has_color(colors[i].cast<double>())) continue;
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
    const std::size_t bin = lab_bin(colors[i]);
    const float ball = std::max(on_ball[k][bin], unseen_share * group.density(row, column));
    if (elsewhere[bin] > (group.core(row, column) ? core_share : fringe_share) * ball) table[i] = no_class;
  }
  return table;
}

std::vector<double> pixels_of_classes(const OccupiedCells& cells, const ColorTable& colors) {
  std::vector<double> pixels(colors.classes.size() + 1, 0);
  for (const CellCount& cell : cells) pixels[colors.table[cell.cell]] += cell.count;
  return pixels;
}

void rebuild(ColorTable& colors) {
  std::vector<ClassEvidence> evidence;
  for (const ColorClass& color : colors.classes)
    evidence.push_back({color.cells, chroma_group(color.histogram)});
  colors.table = class_table(evidence, colors.background);
}

std::optional<ColorTable> before_own_ground(const ColorTable& colors, const cv::Mat& bgr) {
  constexpr double least_share = 0.05;  // of the picture; balls are rarely so large, or so many
  const bool known = std::none_of(colors.classes.begin(), colors.classes.end(),
                                  [](const ColorClass& color) { return color.cells.empty(); });
  if (!known) return std::nullopt;
  ColorTable result = colors;
  CellCounts counts;
  count_cells(bgr, {}, counts);
  result.background = occupied(counts);
  const double all = static_cast<double>(bgr.total());
  if (all - pixels_of_classes(result.background, colors)[no_class] < least_share * all) return std::nullopt;
  rebuild(result);
  return result;
}

}  // namespace ballservo
