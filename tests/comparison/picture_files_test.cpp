#include "app/comparison/pictures/picture_files.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "app/comparison/comparison_archive.hpp"
#include "calibration/base/fault.hpp"
#include "tests/support/faults.hpp"
#include "tests/support/test_data.hpp"

namespace ballservo {
namespace {

// Two pictures of a red disc at (130.3, 90.6), radius 30.2, drawn with 1/256 px.
struct Pictures {
  test::TemporaryFolder folder;
  Pictures() {
    for (const char* name : {"a.png", "b.png"}) {
      cv::Mat picture(200, 260, CV_8UC3, cv::Scalar(120, 120, 110));
      cv::circle(picture, {static_cast<int>(130.3 * 256), static_cast<int>(90.6 * 256)},
                 static_cast<int>(30.2 * 256), {20, 20, 200}, cv::FILLED, cv::LINE_AA, 8);
      cv::GaussianBlur(picture, picture, {}, 0.7);
      cv::imwrite((folder.path() / name).string(), picture);
    }
  }
  PictureFilesOptions with(const std::string& truth) const {
    std::ofstream(folder.path() / "truth.csv") << truth;
    PictureFilesOptions options;
    options.folder = folder.path();
    options.truth = folder.path() / "truth.csv";
    options.start_at_truth = true;
    return options;
  }
};

std::vector<Fault> files_faults(const PictureFilesOptions& options) {
  return test::faults_of([&] { PictureFiles source(options); });
}

bool any_speaks_of(const std::vector<Fault>& faults, const std::string& part) {
  return std::any_of(faults.begin(), faults.end(), [&](const Fault& fault) {
    return (fault.place + fault.found).find(part) != std::string::npos;
  });
}

TEST(PictureFiles, FitsStartFromTheTruthAndFindTheDisc) {
  const Pictures pictures;
  const PictureFiles source(pictures.with(
      "source,frame,ball_id,class,cx_px,cy_px,r_px\na.png,0,,red,130,91,30\nb.png,,,red,131,90,30.5\n"));
  ASSERT_EQ(source.conditions().size(), 1u);
  EXPECT_EQ(source.conditions()[0].name, "red");
  EXPECT_EQ(source.conditions()[0].frames, 2);
  MethodList methods;
  for (const char* name :
       {"paper_one_step", "sphere_one_step", "sphere_converged", "hough_gradient", "hsv_contour", "vpdot2"})
    methods.push_back(find_fit_method(name));
  for (int frame = 0; frame < 2; ++frame) {
    const ComparisonRecord record = measure(source.picture(0, frame), methods);
    for (std::size_t m = 0; m < methods.size(); ++m) {
      ASSERT_TRUE(record.fits[m]) << methods[m]->name;
      const double allowed_px = methods[m]->is_peer ? 1.5 : 0.4;
      EXPECT_LT((record.fits[m]->outline.center_px - Eigen::Vector2d(130.3, 90.6)).norm(), allowed_px)
          << methods[m]->name;
      EXPECT_FALSE(record.fits[m]->p_C.allFinite());  // no camera, no diameter
    }
  }
}

TEST(PictureFiles, SaysEveryFaultAtOnce) {
  const Pictures pictures;
  const std::vector<Fault> faults = files_faults(pictures.with(
      "source,frame,ball_id,cx_px,cy_px,r_px\na.png,0,,130,91,30\na.png,0,,130,91,30\nnone.png,0,,1,2,3\n"
      "b.png,0,,130,,30\nb.png,0,2,x,91,-3\n../truth.csv,0,,1,2,3\n"));
  for (const std::string part :
       {"nothing, as in another row of a.png", "none.png", "r_px", "cx_px", "../truth.csv"})
    EXPECT_TRUE(any_speaks_of(faults, part)) << part;
  EXPECT_FALSE(files_faults(pictures.with("source\n")).empty());
  EXPECT_FALSE(files_faults(pictures.with("picture\na.png\n")).empty());
  PictureFilesOptions votes = pictures.with("source\na.png\n");
  votes.start_at_truth = false;
  EXPECT_TRUE(any_speaks_of(files_faults(votes), "--colors"));
}

TEST(ComparisonArchive, ComesBackAsItWas) {
  const std::vector<ConditionInfo> conditions{{"a", "a ball", 3, "depth_m", "distance", 0.1 + 0.2, true}};
  const MethodList methods{find_fit_method("vote"), find_fit_method("kasa")};
  const std::string text = comparison_setting_text({conditions, methods, 7, {"x.yaml", "{}", true, true}});
  const ComparisonSetting setting = read_comparison_setting(text, "comparison.json");
  EXPECT_EQ(comparison_setting_text(setting), text);
  EXPECT_THROW(read_comparison_setting("{}", "comparison.json"), InputError);
  EXPECT_THROW(read_comparison_setting(text.substr(0, 40), "comparison.json"), InputError);
}

}  // namespace
}  // namespace ballservo
