// Stage 5: where the ball's edge lies, to a fraction of a pixel, from the pixels of a ring around its
// outline.
//
// No picture is resampled: each pixel of the ring keeps its own ray, and with it its exact distance from the
// assumed outline. The ring is cut into arc segments of a few pixels' length; each gives one edge point.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "calibration/camera/ray_table.hpp"
#include "perception/outline/camera_response.hpp"
#include "perception/outline/cone_fit.hpp"
#include "perception/outline/edge_model.hpp"

namespace ballservo {

inline constexpr int most_outline_sectors = 72;

/// A value for each of the outline's sectors of equal angle.
template <class Value>
struct PerSector {
  std::array<Value, most_outline_sectors> values{};
  int count = 0;

  PerSector() = default;
  explicit PerSector(int sectors) : count(std::min(sectors, most_outline_sectors)) {}
  /// The one at an angle from 0 to 2 pi.
  int sector_at(double angle_rad) const {
    return std::clamp(static_cast<int>(angle_rad / (2 * M_PI) * count), 0, count - 1);
  }
  const Value& operator[](int sector) const { return values[static_cast<std::size_t>(sector)]; }
  Value& operator[](int sector) { return values[static_cast<std::size_t>(sector)]; }
};

/// How far outside the outline the edge lies (px), NaN where none was seen; no sectors where none was sought.
using EdgeOffsets = PerSector<float>;

/// The edge of one ball in one picture.
struct OutlineEdges {
  std::vector<EdgePoint> points;  ///< only segments where an edge was found, in order of their angle
  int segments = 0;               ///< all segments, those outside the picture included
  int segments_in_picture = 0;
  double blur_px = 0;  ///< median over the arc segments
};

/// How far outside the fitted outline the edges lie; as many sectors as there are arc segments.
EdgeOffsets edge_offsets(const OutlineEdges& edges, const ConeFit& fit);

/// Measures edges; keeps its buffers between calls.
class EdgeMeter {
 public:
  /// `bgr` is the picture (CV_8UC3) that `rays` belongs to, its grey levels `response` to the light: a
  /// blur mixes light, so that is where an edge has its shape. Empty points for a cone that is not in the
  /// picture.
  void measure(const cv::Mat& bgr, const RayTable& rays, const TangentCone& outline,
               const CameraResponse& response, OutlineEdges& edges);

  /// What the edges that `measure` found say of the camera, the noise of each segment unknown. Counts points
  /// of some weight.
  ResponseEvidence evidence(const cv::Mat& bgr, const RayTable& rays, const TangentCone& outline,
                            const std::vector<EdgePoint>& points);

 private:
  // How the outline runs at one angle.
  struct Station {
    Eigen::Vector3d outward{0, 0, 0};  // unit, perpendicular to the axis
    Eigen::Vector2d pixel_px{0, 0};
    Eigen::Vector2d normal{0, 0};  // unit, of the outline in the picture
    double px_per_rad = 0;         // how fast the outline moves when the cone opens
    bool visible = false;
  };
  // What all segments share.
  struct Ring {
    double radius_px = 0, half_width_px = 0, half_turn_rad = 0;
    int segments = 0, segments_in_picture = 0;
  };
  static Station station_at(const Camera& camera, const TangentCone& cone,
                            const Eigen::Matrix<double, 3, 2>& basis, double angle);
  bool place_ring(cv::Size size, const Camera& camera, const TangentCone& outline);
  void gather(const cv::Mat& bgr, const RayTable& rays, const TangentCone& outline, std::size_t segment);
  std::optional<double> take_samples(const CameraResponse& response);
  std::optional<EdgeProfileFit> fit_segment(const CameraResponse& response);
  template <class Values, class Of>
  std::optional<BothSides<Values>> means_beside(double edge_px, float clear_px, const Of& of) const;
  EdgeProfileFit fit_coded_edge(const CameraResponse& response, const EdgeProfileFit& by_colors,
                                const EdgeProfileOptions& options);
  std::optional<EdgeColors> colors_beside(double edge_px, const CameraResponse& response) const;
  static CodedChannel chroma_between(const EdgeColors& colors, const CameraResponse& response);
  std::optional<EdgeProfileFit> fit_coded(const CodedChannel& channel, const EdgeColors& colors,
                                          const CameraResponse& response, const EdgeProfileFit& start,
                                          const EdgeProfileOptions& options);
  double coarse_chroma_evidence(const EdgeProfileFit& edge);
  double coarse_offset(double reach_px) const;

  Ring ring_;
  std::vector<Station> stations_;
  std::vector<RingColor> pixels_;  // of one segment
  EdgeSamples samples_;
  std::vector<double> blurs_;
};

}  // namespace ballservo
