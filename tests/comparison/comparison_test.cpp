#include "app/comparison/comparison.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <opencv2/imgcodecs.hpp>

#include "app/comparison/comparison_report.hpp"
#include "app/comparison/comparison_tables.hpp"
#include "app/comparison/found.hpp"
#include "app/comparison/pictures/plan_pictures.hpp"
#include "app/comparison/pictures/rendered_frame.hpp"
#include "calibration/base/fault.hpp"
#include "tests/support/test_data.hpp"

namespace ballservo {
namespace {

const char* const tiny_plan =
    "seed: 3\nframes: 2\nmethods: [vote, paper_one_step, paper_steps_2, paper_steps_3_reselect, "
    "paper_converged, paper_robust, sphere_one_step, sphere_steps_2, sphere_converged, sphere_robust, "
    "taubin, "
    "hsv_contour]\n"
    "defaults: {camera: {focal_px: 400, width_px: 320, height_px: 240}, noise: {read: 2}, blur_px: 0.7, "
    "depth_m: 0.6}\n"
    "conditions: [{name: base}, {name: hidden, occlusion: 0.3}, {name: aside, off_axis_rad: 0.2}]\n"
    "design: {type: one_at_a_time, vary: {start.center_px: [3]}}\n";

const ComparisonPlan& plan() {
  static const ComparisonPlan tiny = parse_comparison_plan(tiny_plan, "tiny.yaml", ".");
  return tiny;
}

struct Notebook {
  test::TemporaryFolder folder;
  Journal journal{folder.path() / "journal", "job",
                  [](const std::string&, const std::string&) { return true; }};
};

struct Run : ComparisonResults {
  std::map<std::string, std::string> files;  // by name, those without times
};

Run run(Notebook& book, int threads, const Shard& shard = {}) {
  PlanPictures source(plan());
  const auto units = comparison_units(source.conditions(), shard);
  run_units(source, plan().methods, units, book.journal, threads, [](long) {});
  std::map<std::string, std::string> files;
  const ComparisonResults results =
      collect_results(source.conditions(), plan().methods, units, book.journal, plan().seed,
                      [&](const std::string& name, std::string_view rows) { files[name] += rows; });
  files.erase("timing.csv");
  return {results, files};
}

const Run& tiny(int threads) {
  const auto made = [](int count) {
    Notebook book;
    return run(book, count);
  };
  static const Run one = made(1), two = made(2);
  return threads == 1 ? one : two;
}

std::size_t place(const std::string& name) {
  for (std::size_t m = 0; m < plan().methods.size(); ++m) {
    if (plan().methods[m]->name == name) return m;
  }
  ADD_FAILURE() << name;
  return 0;
}

// Frames whose ball stands at (0.3, 0.4, 1) m and one answer that is off by known amounts.
std::vector<ComparisonRecord> known_errors() {
  std::vector<ComparisonRecord> frames;
  for (int k = 0; k < 2; ++k) {
    ComparisonRecord frame;
    frame.truth.frame = k;
    frame.truth.p_CB = Eigen::Vector3d(0.3, 0.4, 1);
    frame.truth.outline = OutlineEllipse{{100, 100}, 30};
    MethodFit fit;
    fit.outline = {{103, 104}, 31};
    fit.p_C = *frame.truth.p_CB + Eigen::Vector3d(0.0006, 0.0008, -0.002);  // 1 mm outward, 2 mm nearer
    frame.fits = {fit, {}};
    frames.push_back(frame);
  }
  frames[1].fits[0]->outline.center_px.x() = 200;  // locked onto something else
  return frames;
}

ConditionSummary summarize(const std::vector<ComparisonRecord>& frames, const MethodList& methods) {
  ConditionStatistics statistics("known", methods, 1);
  for (const ComparisonRecord& frame : frames) statistics.add(frame);
  return statistics.summary();
}

const MethodList two_methods{find_fit_method("vote"), find_fit_method("paper_one_step")};

TEST(ComparisonStatistics, StateKnownErrors) {
  const ConditionSummary summary = summarize(known_errors(), two_methods);
  const Figures& s = summary.methods[0];
  EXPECT_EQ(s["frames"], 2);
  EXPECT_EQ(s["found"], 1);
  EXPECT_EQ(s["failed"], 1);
  EXPECT_DOUBLE_EQ(s["center_rms_px"], 5);
  EXPECT_DOUBLE_EQ(s["radius_bias_px"], 1);
  EXPECT_NEAR(s["depth_bias_mm"], -2, 1e-9);
  EXPECT_NEAR(s["lateral_bias_mm"], 1, 1e-9);
  EXPECT_NEAR(s["position_median_mm"], std::sqrt(5), 1e-9);
  // One of two is missing: the median is between.
  EXPECT_EQ(s["charged_median_mm"], std::numeric_limits<double>::infinity());
  const Figures& none = summary.methods[1];
  EXPECT_EQ(none["found"], 0);
  EXPECT_TRUE(std::isnan(none["center_rms_px"].get<double>()));
}

TEST(Found, IsWithinAFifthOfTheRadius) {
  const OutlineEllipse truth{{100, 100}, 30};
  EXPECT_TRUE(is_found({{105.9, 100}, 30}, truth));
  EXPECT_FALSE(is_found({{106.1, 100}, 30}, truth));
  EXPECT_TRUE(is_found({{100, 100}, 35.9}, truth));
  EXPECT_FALSE(is_found({{100, 100}, 36.1}, truth));
  EXPECT_FALSE(is_found({{100, 100}, 23.9}, truth));
}

// Whatever is not at the ball is a false ball; a frame without a ball cannot fail.
TEST(ComparisonStatistics, CountFalseBalls) {
  std::vector<ComparisonRecord> frames = known_errors();
  frames[0].fits[0]->others = 2;
  ComparisonRecord empty;
  empty.truth.has_ball = false;
  empty.fits = {MethodFit{}, {}};
  empty.fits[0]->others = 1;
  frames.push_back(empty);
  const ConditionSummary summary = summarize(frames, two_methods);
  EXPECT_EQ(summary.methods[0]["false_balls"], 2 + 1 + 2);
  EXPECT_EQ(summary.methods[0]["found"], 1);
  EXPECT_EQ(summary.methods[0]["failed"], 1);
  EXPECT_EQ(summary.methods[1]["false_balls"], 0);
  EXPECT_EQ(summary.methods[1]["failed"], 2);
  frames[0].truth.outline.reset();
  EXPECT_TRUE(std::isnan(summarize(frames, two_methods).methods[0]["false_balls"].get<double>()));
}

TEST(ComparisonStatistics, HoldPositionsAgainstTheirCovariance) {
  std::vector<ComparisonRecord> frames(2, known_errors()[0]);  // 0.6, 0.8 and 2 mm off
  frames[0].fits[0]->covariance_m2 = 1e-6 * Eigen::Vector3d(0.36, 0.64, 4).asDiagonal().toDenseMatrix();
  frames[1].fits[0]->covariance_m2 = 1e-6 * Eigen::Vector3d(0.36, 0.64, 0.4).asDiagonal().toDenseMatrix();
  const Figures s = summarize(frames, two_methods).methods[0];
  EXPECT_NEAR(s["nees_mean"], (3 + 12) / 2.0, 1e-9);
  EXPECT_EQ(s["inside_95"], 0.5);
  EXPECT_TRUE(std::isnan(summarize(known_errors(), two_methods).methods[0]["nees_mean"].get<double>()));
}

// Of all that a detector reports the nearest at the ball counts, its best where none is.
TEST(WholeDetectors, AreCountedByWhatIsNearestToTheBall) {
  const auto circle = [](double x, double r) {
    MethodFit fit;
    fit.outline = {{x, 100}, r};
    return fit;
  };
  FitMethod detector;
  detector.detect = [&](MethodScene&) {
    return std::vector<MethodFit>{circle(160, 30), circle(104, 30), circle(101, 60), circle(102, 30)};
  };
  CameraParameters parameters;
  parameters.size = {64, 48};
  parameters.fx_px = parameters.fy_px = 60;
  DetectorSetup setup{
      std::make_shared<const RayTable>(Camera(parameters)), std::make_shared<ColorTable>(), {}};
  setup.options.radii = {{0.035, 0}};
  const cv::Mat bgr(48, 64, CV_8UC3, cv::Scalar(0, 0, 0));
  MethodScene scene(bgr, setup, {});
  FrameTruth truth;
  truth.outline = OutlineEllipse{{100, 100}, 30};
  const auto counted = [&] { return *run_methods(scene, {&detector}, truth).front(); };
  EXPECT_EQ(counted().outline.center_px.x(), 102);
  EXPECT_EQ(counted().others, 3);
  truth.outline->center_px.x() = 500;
  EXPECT_EQ(counted().outline.center_px.x(), 160);
}

TEST(ComparisonStatistics, APairBreaksByCentreOrByRadius) {
  std::vector<ComparisonRecord> frames;
  for (int k = 0; k < 40; ++k) {
    ComparisonRecord frame;
    frame.truth.outline = OutlineEllipse{{100, 100}, 30};
    MethodFit one, converged;
    one.outline = converged.outline = *frame.truth.outline;
    converged.outline.center_px.x() += 0.001 * k;
    if (k == 3) converged.outline.center_px.x() += 0.06;
    if (k == 4) converged.outline.radius_px += 0.06;
    if (k == 5) converged.outline.radius_px += 0.04;  // near enough
    frame.fits = {one, converged};
    frames.push_back(frame);
  }
  const Figures s =
      summarize(frames, {find_fit_method("paper_one_step"), find_fit_method("paper_converged")}).pairs[0];
  EXPECT_EQ(s["frames"], 40);
  EXPECT_EQ(s["breaks"], 2);
  EXPECT_NEAR(s["radius_max_px"], 0.06, 1e-9);
  EXPECT_LT(s["center_median_low_px"], s["center_median_px"]);
  EXPECT_GT(s["center_median_high_px"], s["center_median_px"]);
  EXPECT_GT(s["center_median_low_px"], 0.01);
  EXPECT_LT(s["center_median_high_px"], 0.03);
}

TEST(ComparisonTables, LeaveUnknownCellsEmpty) {
  const ConditionInfo info{"known", "", 2, "", "", 0, false};
  const std::vector<ComparisonRecord> frames = known_errors();
  const ConditionSummary summary = summarize(frames, two_methods);
  EXPECT_NE(
      condition_rows(info, summary, two_methods)["compare.csv"].find("known,paper_one_step,2,0,2,,,,,,,,,"),
      std::string::npos);
  EXPECT_NE(frame_rows(info, frames[0], two_methods)["fits.csv"].find(
                "known,rendered,0,paper_one_step,0,,,,,,,,,,,,,,,,,,,,\n"),
            std::string::npos);
  EXPECT_NE(frame_rows(info, frames[1], two_methods)["fits.csv"].find("known,rendered,1,vote,0,200,104,31"),
            std::string::npos);
}

// Every row has as many cells as its heading, and the promised columns come first.
TEST(ComparisonTables, RowsAreAsLongAsTheirHeadings) {
  for (const auto& [name, text] : tiny(1).files) {
    std::size_t begin = 0, commas = 0;
    bool first = true;
    for (std::size_t end = text.find('\n'); end != std::string::npos;
         begin = end + 1, end = text.find('\n', begin)) {
      const auto count = static_cast<std::size_t>(
          std::count(text.begin() + static_cast<long>(begin), text.begin() + static_cast<long>(end), ','));
      if (first) commas = count;
      first = false;
      EXPECT_EQ(count, commas) << name << ": " << text.substr(begin, end - begin);
    }
  }
  EXPECT_EQ(comparison_headings()["compare.csv"].rfind(
                "condition,method,frames,found,failed,center_rms_px,radius_bias_px,"
                "radius_rms_px,position_median_mm,position_p90_mm,position_rms_mm,"
                "depth_bias_mm,lateral_bias_mm,",
                0),
            0u);
  EXPECT_EQ(comparison_headings()["fits.csv"].rfind(
                "condition,source,frame,method,found,cx_px,cy_px,r_px,x_m,y_m,z_m,"
                "iterations,residual_px,",
                0),
            0u);
}

TEST(ComparisonRecord, ComesBackAsItWas) {
  ComparisonRecord record = known_errors()[0];
  record.facts = VoteFacts{57, 120, 0.21};
  record.fits[0]->converged = true;
  record.fits[0]->arc = 0.1 + 0.2;
  record.fits[0]->others = 3;
  record.fits[0]->covariance_m2 = Eigen::Matrix3d::Identity() * 1e-6;
  record.fits[0]->p_C.x() = std::nan("");
  record.fits[0]->outline.radius_px = std::nan("");
  const ComparisonRecord back = record_from_json(nlohmann::json::parse(json_of(record).dump()));
  EXPECT_EQ(json_of(back), json_of(record));
  EXPECT_EQ(back.fits[0]->others, 3);
  EXPECT_TRUE(std::isnan(back.fits[0]->outline.radius_px));
  EXPECT_EQ(*back.fits[0]->covariance_m2, *record.fits[0]->covariance_m2);
  EXPECT_EQ(*back.fits[0]->arc, 0.1 + 0.2);
  EXPECT_TRUE(std::isnan(back.fits[0]->p_C.x()));
  EXPECT_FALSE(back.fits[1]);
}

TEST(RenderedFrame, HidesThePartThatTheConditionAsksFor) {
  ComparisonCondition condition;
  condition.name = "hidden";
  for (const double occlusion : {0.0, 0.3, 0.6}) {
    condition.occlusion = occlusion;
    for (const OcclusionSide side : {OcclusionSide::any, OcclusionSide::above}) {
      condition.occlusion_side = side;
      const RenderedFrame rendered = render_comparison_frame(condition, 1, 2);
      EXPECT_NEAR(rendered.truth.visible_fraction, 1 - occlusion, 0.02);
    }
  }
}

TEST(RenderedFrame, StandsWhereTheConditionSays) {
  ComparisonCondition condition;
  condition.name = "aside";
  condition.off_axis_rad = 0.2;
  for (int frame = 0; frame < 3; ++frame) {
    const Eigen::Vector3d p = render_comparison_frame(condition, 1, frame).truth.p_CB;
    EXPECT_NEAR(std::atan2(p.head<2>().norm(), p.z()), 0.2, 0.004);
    EXPECT_NEAR(p.z(), 1, 0.021);
  }
}

TEST(Comparison, FindsTheBallAndPlacesIt) {
  const ComparisonResults& results = tiny(1);
  for (const std::string name :
       {"vote", "paper_one_step", "paper_converged", "sphere_one_step", "sphere_converged", "taubin"}) {
    for (const std::size_t c : {0u, 2u}) {
      const Figures& s = results.summaries[c].methods[place(name)];
      EXPECT_EQ(s["found"], s["frames"]) << results.conditions[c].name << " " << name;
      EXPECT_LT(s["center_rms_px"], 1.5) << results.conditions[c].name << " " << name;
    }
  }
  // A start that is 3 px off, and still the place is right: the points are looked for again.
  EXPECT_LT(results.summaries[3].methods[place("sphere_one_step")]["center_rms_px"], 0.3);
  EXPECT_GT(results.summaries[3].methods[place("vote")]["center_rms_px"], 1);
}

TEST(Comparison, OneStepIsNearTheConvergedFit) {
  const std::vector<MethodPair> pairs = converged_pairs(plan().methods);
  for (std::size_t k = 0; k < 2; ++k) {
    for (const std::size_t c : {0u, 1u, 2u})
      EXPECT_LT(tiny(1).summaries[c].pairs[k]["center_median_px"], 0.05) << plan().methods[pairs[k].a]->name;
  }
}

TEST(Comparison, IsTheSameAtOneAndTwoThreads) { EXPECT_EQ(tiny(1).files, tiny(2).files); }

TEST(Comparison, ShardsTogetherAreTheWhole) {
  Notebook book;
  run(book, 1, {2, 3});
  const std::size_t part = book.journal.size();
  run(book, 1, {1, 3});
  run(book, 1, {3, 3});
  EXPECT_GT(book.journal.size(), part);
  // Everything is noted by now: nothing is left to be run.
  EXPECT_EQ(run(book, 1).files, tiny(1).files);
}

TEST(Comparison, TheReportHoldsCurvesAndNamesEachPictureThatItWrites) {
  const PlanPictures source(plan());
  const ShowFrame show = [&](std::size_t condition, int frame) { return source.picture(condition, frame); };
  std::map<std::string, std::string> pictures;
  const WriteFile write = [&](const std::string& name, std::string_view bytes) {
    pictures.emplace(name, bytes);
  };
  const auto report = comparison_report(tiny(1), show, write);
  std::size_t named = 0;
  for (const auto& kind : report["photos"]) {
    for (const auto& frame : kind) {
      const std::string& bytes = pictures[frame["file"]];
      EXPECT_FALSE(cv::imdecode(std::vector<char>(bytes.begin(), bytes.end()), cv::IMREAD_COLOR).empty());
      ++named;
    }
  }
  EXPECT_EQ(named, pictures.size());
  EXPECT_GT(named, 2u);
  EXPECT_EQ(report["methods"].size(), plan().methods.size());
  ASSERT_EQ(report["one_step_pairs"].size(), 2u);
  EXPECT_EQ(report["one_step_pairs"][0]["one_step"], "sphere_one_step");  // what runs on line
  EXPECT_EQ(report["one_step_pairs"][1]["one_step"], "paper_one_step");
  EXPECT_FALSE(report["one_step_pairs"][0]["apart_px"].empty());
  EXPECT_TRUE(comparison_report(tiny(1), {}, write)["photos"].empty());
}

// What the others were at work on is left half drawn, and must not be noted.
TEST(Comparison, EndsWhenItIsToldToAndGoesOnAsIfUndisturbed) {
  struct Stop {};
  for (const long stop_after : {1, 5}) {
    PlanPictures source(plan());
    Notebook book;
    const auto units = comparison_units(source.conditions());
    EXPECT_THROW(run_units(source, plan().methods, units, book.journal, 2,
                           [&](long done) {
                             if (done >= stop_after) throw Stop();
                           }),
                 Stop);
    EXPECT_EQ(run(book, 2).files, tiny(1).files) << stop_after;
  }
}

// The report draws the worst frames again by their numbers.
TEST(Comparison, TheWorstFramesAreNamedByTheirNumbers) {
  const std::vector<ConditionInfo> conditions{{"many", "", 20, "", "", 0, false}};
  Notebook book;
  const auto units = comparison_units(conditions);
  ASSERT_GT(units.size(), 1u);
  for (const ComparisonUnit& unit : units) {
    nlohmann::json records = nlohmann::json::array();
    for (int k = unit.first_frame; k < unit.first_frame + unit.frames; ++k) {
      ComparisonRecord frame;
      frame.truth.frame = k;
      frame.truth.outline = OutlineEllipse{{100, 100}, 30};
      MethodFit fit;
      fit.outline = {{100 + 0.1 * (k % 13), 100}, 30};  // frame 12 is the worst, then 11
      frame.fits = {std::nullopt, fit};
      records.push_back(json_of(frame));
    }
    book.journal.add(unit.key, records.dump());
  }
  const ComparisonResults results = collect_results(conditions, two_methods, units, book.journal, 1,
                                                    [](const std::string&, std::string_view) {});
  ASSERT_EQ(results.worst.size(), 2u);
  EXPECT_EQ(results.worst[0].index, 12);
  EXPECT_EQ(results.worst[1].index, 11);
  for (const NotableFrame& frame : results.worst) EXPECT_EQ(frame.index, frame.record.truth.frame);
}

TEST(Comparison, RefusesDamagedNotes) {
  Notebook book;
  PlanPictures source(plan());
  const auto units = comparison_units(source.conditions());
  for (const ComparisonUnit& unit : units) book.journal.add(unit.key, "[{\"source\": 3}]");
  EXPECT_THROW(collect_results(source.conditions(), plan().methods, units, book.journal, 1,
                               [](const std::string&, std::string_view) {}),
               InputError);
}

}  // namespace
}  // namespace ballservo
