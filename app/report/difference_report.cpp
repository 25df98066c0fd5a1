#include "app/report/difference_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "app/report/heat_plot.hpp"
#include "app/report/page.hpp"

namespace ballservo {
namespace {

constexpr double color_medians = 5;  // the brightest colour stands for so many medians and more
constexpr double degrees = 180 / M_PI;

std::string mm(double value_m) { return fmt::format("{:.3g} mm", 1e3 * value_m); }

/// Draws tell no more than a thousandth.
std::string percent(double chance) {
  return chance < 1e-3 ? "less than 0.1 %" : fmt::format("{:.3g} %", 100 * chance);
}

std::vector<double> ball_values_mm(const CameraDifference& difference, bool sigma) {
  std::vector<double> values;
  for (const DifferencePlace& place : difference.places) {
    const bool known = sigma ? place.ball_sigma_m.has_value() : place.ball_m.has_value();
    values.push_back(!known ? std::nan("") : 1e3 * (sigma ? *place.ball_sigma_m : place.ball_m->norm()));
  }
  return values;
}

HeatPlot plot_of(const ComparedCameras& compared, const std::string& title, std::vector<double> values) {
  HeatPlot plot;
  plot.title = title;
  plot.unit = "mm";
  plot.picture = compared.size;
  plot.columns = compared.difference.columns, plot.rows = compared.difference.rows;
  plot.values = std::move(values);
  plot.high =
      1e3 * std::min(compared.difference.ball_m.max, color_medians * compared.difference.ball_m.median);
  return plot;
}

Svg difference_map(const ComparedCameras& compared, double& arrow_scale) {
  const CameraDifference& d = compared.difference;
  HeatPlot plot =
      plot_of(compared, "Difference at the ball, and displacement in the picture", ball_values_mm(d, false));
  const double spacing = 2.0 * compared.size.width_px / std::max(1, plot.columns - 1);
  arrow_scale = arrow_scale_for(d.shift_px.median, 0.7 * spacing);
  plot.arrow_scale = arrow_scale;
  for (const DifferencePlace& place : d.places) {
    const bool drawn = place.shift_px && arrow_scale * place.shift_px->norm() < 3 * spacing;
    plot.arrows_px.push_back(drawn ? *place.shift_px : Eigen::Vector2d::Constant(std::nan("")));
  }
  return heat_plot(plot);
}

void add_worst_places(Page& page, const CameraDifference& difference) {
  std::vector<const DifferencePlace*> sorted;
  for (const DifferencePlace& place : difference.places)
    if (place.ball_m) sorted.push_back(&place);
  std::stable_sort(sorted.begin(), sorted.end(), [](const DifferencePlace* a, const DifferencePlace* b) {
    return a->ball_m->squaredNorm() > b->ball_m->squaredNorm();
  });
  PageTable table;
  table.heading = {"place (px)", "displacement (px)", "x (mm)",    "y (mm)",
                   "z (mm)",     "together (mm)",     "sigma (mm)"};
  table.caption = "The places where the two differ most at the ball.";
  for (std::size_t i = 0; i < std::min<std::size_t>(sorted.size(), 8); ++i) {
    const DifferencePlace& p = *sorted[i];
    table.rows.push_back(
        {fmt::format("{:.0f}, {:.0f}", p.pixel_px.x(), p.pixel_px.y()),
         p.shift_px ? fmt::format("{:.3f}", p.shift_px->norm()) : "",
         fmt::format("{:.3f}", 1e3 * p.ball_m->x()), fmt::format("{:.3f}", 1e3 * p.ball_m->y()),
         fmt::format("{:.3f}", 1e3 * p.ball_m->z()), fmt::format("{:.3f}", 1e3 * p.ball_m->norm()),
         p.ball_sigma_m ? fmt::format("{:.3f}", 1e3 * *p.ball_sigma_m) : ""});
  }
  page.table(table);
}

}  // namespace

std::string uncertainty_verdict(const ComparedCameras& compared) {
  const CameraDifference& d = compared.difference;
  if (!compared.known_a && !compared.known_b)
    return "How uncertain the two calibrations are is not known (no .covariance.json beside the files), so "
           "whether the difference means anything cannot be said.";
  if (!d.ball_sigma_rms_m)
    return "The calibrations are so uncertain that what it does to the ball cannot be computed.";
  if (!d.chance)
    return fmt::format(
        "Only {}'s uncertainty is known: the difference is {:.1f} times what it alone lets expect at the "
        "ball "
        "(RMS over the picture). Whether it is more than both allow cannot be said.",
        compared.known_a ? compared.name_a : compared.name_b, *d.sigmas_rms);
  const std::string expected = fmt::format(
      "at the ball it is {:.1f} times its sigma (RMS over the picture), and as much or more happens "
      "by chance in {} of such pairs",
      *d.sigmas_rms, percent(*d.chance));
  if (*d.chance >= least_chance)
    return "The difference is within what the calibrations' uncertainties allow: " + expected + ".";
  return "The difference is more than the calibrations' uncertainties allow: " + expected +
         ". Either the camera changed in between (focus, zoom, a knock), or a lens model does not fit.";
}

std::string difference_page(const ComparedCameras& compared) {
  const CameraDifference& d = compared.difference;
  Page page("Two cameras compared", compared.name_a + " and " + compared.name_b);
  page.note(fmt::format(
      "A ball of {:g} mm at {:g} m is read {} apart (median over the picture; RMS {}, at most {}).",
      1e3 * compared.options.diameter_m, compared.options.range_m, mm(d.ball_m.median), mm(d.ball_m.rms),
      mm(d.ball_m.max)));
  page.paragraph(uncertainty_verdict(compared));
  page.key_values(
      {{"displacement in the picture", fmt::format("median {:.4f} px, RMS {:.4f} px, largest {:.4f} px",
                                                   d.shift_px.median, d.shift_px.rms, d.shift_px.max)},
       {"rotation taken out", fmt::format("{:.4f} deg (about x {:.4f}, y {:.4f}, z {:.4f})",
                                          degrees * d.rotation_rad.norm(), degrees * d.rotation_rad.x(),
                                          degrees * d.rotation_rad.y(), degrees * d.rotation_rad.z())},
       {"picture", fmt::format("{} x {} px", compared.size.width_px, compared.size.height_px)}});
  double arrow_scale = 1;
  const Svg map = difference_map(compared, arrow_scale);
  page.figure(drawing(
      map, fmt::format("Colour: how far apart the two read the ball's centre. Arrows, {:g} times as long as "
                       "they are: from where the first camera sees a ray to where the second does; overlong "
                       "ones are left out. Without "
                       "colour: the ball would not be wholly in the picture there.",
                       arrow_scale)));
  if (d.ball_sigma_rms_m)
    page.figure(drawing(heat_plot(plot_of(compared, "What the uncertainties let expect at the ball (1 sigma)",
                                          ball_values_mm(d, true))),
                        "Where this is large, the boards did not reach: photograph the board there."));
  add_worst_places(page, d);
  page.heading("Why a rotation is taken out");
  page.paragraph(
      "No board says where a camera's frame points: a frame turned a little, with the principal point moved "
      "to make up for it, fits the same pictures as well. Two good calibrations of one camera may therefore "
      "have principal points some pixels apart and mean the same. So the rotation that brings the two "
      "sets of rays closest over most of the picture is applied first; what is left is a "
      "difference that no turning of the camera explains. Where a robot's mount was measured with the one "
      "camera, the rotation itself counts too: measure it anew with the other.");
  return page.html();
}

}  // namespace ballservo
