// One view of the scene, pixel by pixel: first every pixel by its centre, then those that an edge crosses
// again.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "servo/simulation/rendering/edge_pixel.hpp"
#include "servo/simulation/rendering/lens_rays.hpp"

namespace ballservo {

class ViewPainter {
 public:
  /// Rays and scene must outlive it.
  ViewPainter(const LensRays& rays, const Scene& scene, const Eigen::Isometry3d& X_WC);

  /// As CameraRenderer::radiance of one view.
  cv::Mat paint();

 private:
  /// A cone that holds a solid.
  struct SolidCone {
    Eigen::Vector3d axis{0, 0, 1};
    double angle_rad = 3.14, min_cosine = -1;
  };

  struct Tile;

  void paint_centers(int top, Tile& tile);
  void look_into(Tile& tile) const;
  void cast_rays(Tile& tile) const;
  void paint_centers(const Tile& tile);
  void paint_edges(int row, std::vector<int>& near_solids, std::vector<NearBall>& near_balls);
  int show_center(int row, int column, int surface, float t, Rgb& color) const;

  Eigen::Vector3d corner(int row, int column) const;
  Eigen::Vector3d center_ray(int row, int column) const;
  Triples center_rays(int row, int column) const;
  Ints beside_balls(const Triples& directions) const;
  /// The cosine to a ball's middle above which a pixel may lie in the ball or on its outline.
  double near_cosine(const BallCone& cone) const;
  void set_color(int row, int column, const Rgb& color);

  const LensRays& rays_;
  const Scene& scene_;
  const Viewpoint view_;
  const Eigen::Matrix3f R_WC_;
  const double reach_rad_;  // of a pixel from its centre
  std::vector<SolidCone> solids_;
  cv::Mat surfaces_;  // what each pixel shows at its centre
  cv::Mat colors_;
};

}  // namespace ballservo
