// OpenCV's camera files: what its own programs write, what its own library reads of ours, and what is
// refused.
#include <gtest/gtest.h>

#include <opencv2/calib3d.hpp>
#include <opencv2/core/persistence.hpp>

#include "tests/calibration/camera_format_fixture.hpp"

namespace ballservo {
namespace {

using OpenCVFiles = test::CameraFormats;
using test::format_examples;
using test::largest_difference_px;
using test::replaced;

TEST_F(OpenCVFiles, ReadsWhatWeWriteAndProjectsAlike) {
  for (const auto& example : format_examples()) {
    const CameraParameters& p = example.parameters;
    if (p.model == LensModel::visp) continue;
    const Camera camera(p);
    const std::string text = camera_file_text(camera, camera_file_format("opencv", ""), "left");
    cv::FileStorage storage(text, cv::FileStorage::READ | cv::FileStorage::MEMORY);
    cv::Mat matrix, distortion;
    storage["camera_matrix"] >> matrix;
    storage["distortion_coefficients"] >> distortion;
    EXPECT_EQ(static_cast<int>(storage["image_width"]), 640);
    EXPECT_EQ(static_cast<std::string>(storage["camera_name"]), "left");
    ASSERT_EQ(matrix.type(), CV_64F);
    EXPECT_EQ(matrix.at<double>(0, 0), p.fx_px) << example.name;
    EXPECT_EQ(matrix.at<double>(1, 2), p.cy_px);
    const bool fisheye = static_cast<int>(storage["fisheye_model"]) == 1;
    EXPECT_EQ(fisheye, p.model == LensModel::kannala_brandt);
    for (const cv::Point3d& point : {cv::Point3d(0.3, -0.2, 1), cv::Point3d(-0.5, 0.35, 1.1)}) {
      std::vector<cv::Point2d> seen;
      const std::vector<cv::Point3d> points{point};
      if (fisheye)
        cv::fisheye::projectPoints(points, seen, cv::Vec3d(), cv::Vec3d(), matrix, distortion);
      else
        cv::projectPoints(points, cv::Vec3d(), cv::Vec3d(), matrix, distortion, seen);
      const auto ours = camera.project({point.x, point.y, point.z});
      ASSERT_TRUE(ours);
      EXPECT_LT((*ours - Eigen::Vector2d(seen[0].x, seen[0].y)).norm(), 1e-9) << example.name;
    }
  }
}

/// What OpenCV's own writer makes of the keys of its calibration program.
std::string opencv_text(const cv::Mat& distortion, int type = CV_64F) {
  cv::FileStorage storage(".yml", cv::FileStorage::WRITE | cv::FileStorage::MEMORY);
  storage << "calibration_time"
          << "Sat 21 Nov 2026 05:57:46 PM UTC"
          << "nr_of_frames" << 13;
  storage << "image_width" << 640 << "image_height" << 480 << "board_width" << 9 << "square_size" << 25.f;
  storage.writeComment("flags: +fix_principal_point +zero_tangent_dist");
  storage << "flags" << 6;
  cv::Mat matrix = (cv::Mat_<double>(3, 3) << 535.25, 0, 320.5, 0, 536.75, 240.5, 0, 0, 1);
  matrix.convertTo(matrix, type);
  storage << "camera_matrix" << matrix << "distortion_coefficients" << distortion;
  storage << "avg_reprojection_error" << 0.39;
  storage << "per_view_reprojection_errors" << (cv::Mat_<float>(2, 1) << 0.1f, NAN);
  storage << "image_points" << cv::Mat(2, 3, CV_32FC2, cv::Scalar(1.5, 2.5));
  storage << "grid_points" << std::vector<cv::Point3f>{{0, 0, 0}, {1, 0, 0}} << "none" << cv::Mat();
  return storage.releaseAndGetString();
}

cv::Mat column(const std::vector<double>& values) { return cv::Mat(values).clone(); }

TEST_F(OpenCVFiles, OfItsOwnWriterWithEveryNumberOfCoefficients) {
  const std::vector<double> all{-0.28, 0.05, 1e-3, -5e-4, 0.09, 0.1, 0.2, 0.05};
  for (const std::size_t count : {4u, 5u, 8u, 12u, 14u}) {
    std::vector<double> values(all.begin(), all.begin() + static_cast<long>(std::min<std::size_t>(count, 8)));
    values.resize(count);
    for (const bool row : {false, true}) {
      const cv::Mat matrix = column(values);
      const CameraParameters p = read(opencv_text(row ? cv::Mat(matrix.t()) : matrix)).parameters();
      EXPECT_EQ(p.model, count < 8 ? LensModel::brown : LensModel::brown8);
      EXPECT_EQ(p.fx_px, 535.25);
      EXPECT_EQ(p.cy_px, 240.5);
      for (std::size_t i = 0; i < 8; ++i) EXPECT_EQ(p.coefficients[i], i < count ? values[i] : 0);
    }
    if (count < 12) continue;
    values.back() = 1e-6;
    const std::string faults = faults_of(opencv_text(column(values)));
    EXPECT_NE(faults.find("thin prism"), std::string::npos) << faults;
    EXPECT_EQ(std::count(faults.begin(), faults.end(), '\n'), 1) << faults;
  }
  EXPECT_EQ(read(opencv_text(column(std::vector<double>(5)))).parameters().model, LensModel::pinhole);
  EXPECT_EQ(read(opencv_text(column({0.1, 0, 0, 0}), CV_32F)).parameters().fx_px, 535.25);
  for (const std::size_t count : {1u, 3u, 6u, 13u})
    EXPECT_NE(faults_of(opencv_text(column(std::vector<double>(count, 0.1)))).find("4, 5, 8, 12 or 14"),
              std::string::npos);
}

TEST_F(OpenCVFiles, Fisheye) {
  const auto fisheye = [](const std::string& flag) {
    return replaced(opencv_text(column({0.087, -0.35, 0.4, -0.2})), "flags: 6\n", "flags: 6\n" + flag);
  };
  EXPECT_EQ(read(fisheye("fisheye_model: 1\n")).parameters().model, LensModel::kannala_brandt);
  EXPECT_EQ(read(fisheye("fisheye_model: 0\n")).parameters().model, LensModel::brown);
  EXPECT_NE(faults_of(fisheye("fisheye_model: 2\n")), "");
  EXPECT_NE(faults_of(fisheye("fisheye: 1\n")), "");
  EXPECT_NE(faults_of(fisheye("xi: 1.2\n")), "");
  EXPECT_NE(faults_of(fisheye("camera_model: omni\n")), "");
  EXPECT_EQ(faults_of(fisheye("rms: 0.2\n")), "");
  const std::string five =
      replaced(opencv_text(column({0.1, 0, 0, 0, 0.1})), "flags: 6\n", "fisheye_model: 1\n");
  EXPECT_NE(faults_of(five).find("5 coefficients with fisheye_model: 1"), std::string::npos);
}

TEST_F(OpenCVFiles, InTheSpellingsOfItsOtherPrograms) {
  const std::string usual = opencv_text(column({-0.28, 0.05, 1e-3, -5e-4, 0.09}));
  std::string text =
      replaced(usual, "image_width: 640\nimage_height: 480\n", "cameraResolution: [ 640, 480 ]\n");
  text = replaced(text, "camera_matrix:", "cameraMatrix:");
  text = replaced(text, "distortion_coefficients:", "dist_coeffs:");
  EXPECT_LE(largest_difference_px(read(text), read(usual)), 0);
  text = replaced(usual, "image_width:", "image_Width:");
  text = replaced(text, "camera_matrix:", "Camera_Matrix:");
  text = replaced(text, "distortion_coefficients:", "Distortion_Coefficients:");
  EXPECT_LE(largest_difference_px(read(text), read(usual)), 0);
  EXPECT_LE(largest_difference_px(read(replaced(usual, "%YAML:1.0\n---\n", "%YAML:1.0\n")), read(usual)), 0);
  EXPECT_LE(largest_difference_px(read(replaced(usual, "%YAML:1.0", "%YAML 1.2")), read(usual)), 0);
  EXPECT_NE(faults_of(replaced(usual, "flags: 6", "imageWidth: 640")).find("second time"), std::string::npos);
}

TEST_F(OpenCVFiles, Faults) {
  const std::string text = opencv_text(column({-0.28, 0.05, 1e-3, -5e-4, 0.125}));
  const std::string name = "camera_matrix: !!opencv-matrix\n   rows: 3\n   cols: 3\n";
  const std::vector<std::pair<std::string, std::string>> changes{
      {name, "camera_matrix: !!opencv-matrix\n   rows: 4\n   cols: 3\n"},
      {name, "camera_matrix: !!opencv-matrix\n   rows: 9\n   cols: 1\n"},
      {name, "camera_matrix: !!opencv-matrix\n   rows: -3\n   cols: -3\n"},
      {name, "camera_matrix: !!opencv-matrix\n   rows: 3\n"},
      {name, "camera_matrix: !!python/object:os.system\n   rows: 3\n   cols: 3\n"},
      {name + "   dt: d", name + "   dt: u"},
      {name + "   dt: d", name + "   dt: \"2d\""},
      {name + "   dt: d", name},
      {"5.3525000000000000e+02, 0., 3.2050", "5.3525000000000000e+02, 3.2050"},
      {"5.3525000000000000e+02, 0.", "5.3525000000000000e+02, 0.5"},
      {"5.3525000000000000e+02", "-5.3525000000000000e+02"},
      {"5.3525000000000000e+02", ".Nan"},
      {"5.3525000000000000e+02", ".Inf"},
      {"5.3525000000000000e+02", "wide"},
      {"image_width: 640\n", ""},
      {"image_width: 640", "image_width: 0"},
      {"image_width: 640", "image_width: 640.5"},
      {"image_width: 640", "image_width: 640\nimage_width: 641"},
      {"camera_matrix:", "camera_matrx:"},
      {"distortion_coefficients:", "distortion_coeficients:"},
      {"distortion_coefficients: !!opencv-matrix\n   rows: 5",
       "distortion_coefficients: !!opencv-matrix\n   rows: 4"},
      {"distortion_coefficients: !!opencv-matrix", "distortion_coefficients: 3"},
      {"1.2500000000000000e", "1.2500000000000000f"},
      {"1.2500000000000000e-01", "x"},
  };
  for (const auto& [what, with] : changes)
    EXPECT_NE(faults_of(replaced(text, what, with)), "") << what << " -> " << with;
  for (std::size_t end = 0; end < text.find("avg_reprojection_error"); end += 11)
    EXPECT_NE(faults_of(text.substr(0, end)), "") << "cut at " << end;
  const std::string faults = faults_of(
      replaced(replaced(text, "image_width: 640", "image_width: many"), "5.3525000000000000e+02", "-1"));
  EXPECT_NE(faults.find("camera.any:5: image_width"), std::string::npos) << faults;
  EXPECT_EQ(std::count(faults.begin(), faults.end(), '\n'), 2) << faults;
}

TEST_F(OpenCVFiles, XmlIsRefusedByName) {
  const std::string faults = faults_of("<?xml version=\"1.0\"?>\n<opencv_storage>\n</opencv_storage>\n");
  EXPECT_NE(faults.find("OpenCV"), std::string::npos) << faults;
}

}  // namespace
}  // namespace ballservo
