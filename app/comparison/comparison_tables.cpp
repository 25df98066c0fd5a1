#include "app/comparison/comparison_tables.hpp"

#include <initializer_list>

#include "calibration/base/csv_table.hpp"
#include "calibration/base/numbers.hpp"

namespace ballservo {
namespace {

// ",1.5,,3": what is not finite stays empty.
std::string cells(std::initializer_list<double> values) {
  std::string text;
  for (const double value : values) text += ',' + number_text(value);
  return text;
}

template <class T>
std::string cell(const std::optional<T>& value) {
  return ',' + (value ? number_text(static_cast<double>(*value)) : std::string());
}

}  // namespace

std::string compare_csv_header() {
  return "condition,method,frames,found,failed,center_rms_px,radius_bias_px,radius_rms_px,position_median_mm,"
         "position_p90_mm,position_rms_mm,depth_bias_mm,lateral_bias_mm,"
         "found_low,found_high,center_median_px,position_median_low_mm,position_median_high_mm,"
         "depth_spread_mm,depth_rms_mm,lateral_spread_mm,charged_median_mm,bound_rms_mm,rms_over_bound,"
         "rms_over_bound_low,rms_over_bound_high,iterations_median,unconverged,"
         "radius_median_px,false_balls,false_per_1000,nees_mean,inside_95\n";
}

std::string compare_csv_rows(const ConditionInfo& info, const ConditionSummary& summary,
                             const MethodList& methods) {
  std::string rows;
  for (std::size_t m = 0; m < methods.size(); ++m) {
    const MethodStatistics& s = summary.methods[m];
    rows += info.name + ',' + methods[m]->name + ',' + std::to_string(s.frames) + ',' +
            std::to_string(s.found) + ',' + std::to_string(s.failed);
    rows += cells({s.center_rms_px, s.radius_bias_px, s.radius_rms_px, s.position_median_mm,
                   s.position_p90_mm, s.position_rms_mm, s.depth_bias_mm, s.lateral_bias_mm});
    rows += cells({s.found_ci95.low,
                   s.found_ci95.high,
                   s.center_median_px,
                   s.position_median_ci95_mm.low,
                   s.position_median_ci95_mm.high,
                   s.depth_spread_mm,
                   s.depth_rms_mm,
                   s.lateral_spread_mm,
                   s.charged_median_mm,
                   s.bound_rms_mm,
                   s.rms_over_bound,
                   s.rms_over_bound_ci95.low,
                   s.rms_over_bound_ci95.high,
                   s.iterations_median,
                   s.unconverged,
                   s.radius_median_px,
                   s.false_balls,
                   1000 * s.false_balls / s.frames,
                   s.nees_mean,
                   s.inside_95});
    rows += '\n';
  }
  return rows;
}

std::string pairs_csv_header() {
  return "condition,method_a,method_b,frames,center_median_px,center_max_px,radius_median_px,radius_max_px,"
         "position_median_mm,position_max_mm,"
         "breaks,center_median_low_px,center_median_high_px,position_median_low_mm,position_median_high_mm\n";
}

std::string pairs_csv_rows(const ConditionInfo& info, const ConditionSummary& summary,
                           const MethodList& methods) {
  std::string rows;
  const std::vector<MethodPair> pairs = converged_pairs(methods);
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const PairStatistics& s = summary.pairs[k];
    rows += info.name + ',' + methods[pairs[k].a]->name + ',' + methods[pairs[k].b]->name + ',' +
            std::to_string(s.frames);
    rows += cells({s.center_median_px, s.center_max_px, s.radius_median_px, s.radius_max_px,
                   s.position_median_mm, s.position_max_mm});
    rows += ',' + std::to_string(s.breaks) +
            cells({s.center_median_ci95_px.low, s.center_median_ci95_px.high, s.position_median_ci95_mm.low,
                   s.position_median_ci95_mm.high});
    rows += '\n';
  }
  return rows;
}

std::string tests_csv_header() {
  return "condition,method_a,method_b,frames,difference_median_mm,difference_low_mm,difference_high_mm,"
         "wilcoxon_p,holm_p,only_a,only_b,mcnemar_p\n";
}

std::string tests_csv_rows(const ConditionInfo& info, const ConditionSummary& summary,
                           const MethodList& methods) {
  std::string rows;
  for (const PairedTest& t : summary.tests) {
    rows += info.name + ',' + methods[t.pair.a]->name + ',' + methods[t.pair.b]->name + ',' +
            std::to_string(t.frames);
    rows += cells({t.difference_median_mm, t.difference_ci95_mm.low, t.difference_ci95_mm.high, t.wilcoxon_p,
                   t.holm_p});
    rows += ',' + std::to_string(t.only_a) + ',' + std::to_string(t.only_b) + cells({t.mcnemar_p}) + '\n';
  }
  return rows;
}

std::string timing_csv_header() { return "condition,method,time_us_median\n"; }

std::string timing_csv_rows(const ConditionInfo& info, const ConditionSummary& summary,
                            const MethodList& methods) {
  std::string rows;
  for (std::size_t m = 0; m < methods.size(); ++m)
    rows += info.name + ',' + methods[m]->name + cells({summary.methods[m].time_us_median}) + '\n';
  return rows;
}

std::string fits_csv_header() {
  return "condition,source,frame,method,found,cx_px,cy_px,r_px,x_m,y_m,z_m,iterations,residual_px,"
         "step_px,arc,condition_number,converged,next_step_px,others,"
         "sxx_m2,sxy_m2,sxz_m2,syy_m2,syz_m2,szz_m2\n";
}

std::string fits_csv_rows(const ConditionInfo& info, const ComparisonRecord& record,
                          const MethodList& methods) {
  std::string rows;
  const std::string place =
      info.name + ',' + csv_cell(record.truth.source) + ',' + std::to_string(record.truth.frame) + ',';
  for (std::size_t m = 0; m < methods.size(); ++m) {
    const auto& fit = record.fits[m];
    rows += place + methods[m]->name + (fit && at_the_ball(*fit, record.truth) ? ",1" : ",0");
    if (!fit) {
      rows += ",,,,,,,,,,,,,,,,,,,,\n";
      continue;
    }
    rows += cells({fit->outline.center_px.x(), fit->outline.center_px.y(), fit->outline.radius_px,
                   fit->p_C.x(), fit->p_C.y(), fit->p_C.z()});
    rows += cell(fit->iterations) + cell(fit->residual_px) + cell(fit->step_px) + cell(fit->arc) +
            cell(fit->condition) + cell(fit->converged) + cell(fit->next_step_px) + ',' +
            std::to_string(fit->others);
    if (const auto& s = fit->covariance_m2) {
      rows += cells({(*s)(0, 0), (*s)(0, 1), (*s)(0, 2), (*s)(1, 1), (*s)(1, 2), (*s)(2, 2)});
    } else {
      rows += ",,,,,,";
    }
    rows += '\n';
  }
  return rows;
}

std::string frames_csv_header() {
  return "condition,source,frame,cx_px,cy_px,r_px,x_m,y_m,z_m,visible_fraction,bound_mm,bound_depth_mm,"
         "votes,vote_points,vote_quality,edge_passes\n";
}

std::string frames_csv_row(const ConditionInfo& info, const ComparisonRecord& record) {
  const FrameTruth& truth = record.truth;
  std::string row = info.name + ',' + csv_cell(truth.source) + ',' + std::to_string(truth.frame);
  row += truth.outline
             ? cells({truth.outline->center_px.x(), truth.outline->center_px.y(), truth.outline->radius_px})
             : ",,,";
  row += truth.p_CB ? cells({truth.p_CB->x(), truth.p_CB->y(), truth.p_CB->z()}) : ",,,";
  row += cell(truth.visible_fraction);
  const auto mm = [](const std::optional<double>& m) { return m ? std::optional<double>(1000 * *m) : m; };
  row += cell(mm(truth.bound_m)) + cell(mm(truth.bound_depth_m));
  row += record.facts ? ',' + std::to_string(record.facts->votes) + ',' +
                            std::to_string(record.facts->points) + cells({record.facts->quality})
                      : std::string(",,,");
  row += record.passes > 0 ? ',' + std::to_string(record.passes) : std::string(",");
  return row + '\n';
}

}  // namespace ballservo
