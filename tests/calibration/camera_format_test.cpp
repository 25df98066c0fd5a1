// The formats of OpenCV and Kalibr, and all formats against each other and against the libraries they are of.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/persistence.hpp>
#include <sstream>

#include "calibration/camera/camera_file.hpp"
#include "calibration/files/fault.hpp"
#include "tests/calibration/camera_examples.hpp"
#include "tests/support/test_data.hpp"

namespace ballservo {
namespace {

using test::camera_parameters;

class CameraFormats : public testing::Test {
 protected:
  std::string file(const std::string& name, const std::string& contents) {
    const auto path = folder_.path() / name;
    std::ofstream(path, std::ios::binary) << contents;
    return path.string();
  }
  Camera read(const std::string& contents, const std::string& camera_name = "") {
    return read_camera(file("camera.any", contents) + camera_name);
  }
  /// The faults of reading such a file, a line each; empty if it was accepted.
  std::string faults_of(const std::string& contents, const std::string& camera_name = "") {
    try {
      read(contents, camera_name);
    } catch (const InputError& error) {
      std::string lines;
      for (const Fault& fault : error.faults()) lines += to_text(fault) + "\n";
      return lines;
    }
    return "";
  }
  test::TemporaryFolder folder_;
};

std::string replaced(std::string text, const std::string& what, const std::string& with) {
  const auto at = text.find(what);
  EXPECT_NE(at, std::string::npos) << what;
  return text.replace(at, what.size(), with);
}

std::vector<test::CameraExample> examples() {
  auto list = test::camera_examples();
  list.push_back({"brown_4", camera_parameters(LensModel::brown, 533, {-0.2845, 0.0565, 1e-5, -5e-7, 0})});
  return list;
}

/// The text of a camera in a format; empty where the format cannot hold it, and then the refusal names the
/// model.
std::string text_or_refusal(const Camera& camera, const CameraFileFormat& format) {
  try {
    return camera_file_text(camera, format, "cam0");
  } catch (const InputError& error) {
    const std::string name(lens_model_name(camera.parameters().model));
    EXPECT_EQ(error.faults().size(), 1u);
    EXPECT_NE(error.faults().front().found.find(name), std::string::npos) << error.what();
    EXPECT_NE(error.faults().front().place.find(format.title), std::string::npos) << error.what();
    return "";
  }
}

/// The largest distance (px) at which two cameras see the same point of the first one's pixels.
double largest_difference_px(const Camera& a, const Camera& b) {
  double largest = 0;
  for (int v = 0; v < a.size().height_px; v += 37)
    for (int u = 0; u < a.size().width_px; u += 31) {
      const auto ray = a.unproject({u, v});
      if (!ray) continue;
      const auto first = a.project(*ray), second = b.project(*ray);
      if (!first || !second) return 1e9;
      largest = std::max(largest, (*first - *second).norm());
    }
  return largest;
}

TEST_F(CameraFormats, FromEachToEachWithoutLoss) {
  std::map<std::string, std::set<std::string>> holds;
  for (const auto& example : examples()) {
    CameraParameters p = example.parameters;
    p.fx_px += 1.0 / 3, p.cx_px -= 1.0 / 7;
    const Camera camera(p);
    for (const CameraFileFormat& first : camera_file_formats()) {
      const std::string text = text_or_refusal(camera, first);
      if (text.empty()) continue;
      holds[std::string(first.name)].insert(example.name);
      const Camera once = read(text);
      EXPECT_EQ(once.size(), camera.size());
      for (const CameraFileFormat& second : camera_file_formats()) {
        const std::string again = text_or_refusal(once, second);
        if (again.empty()) continue;
        EXPECT_LE(largest_difference_px(camera, read(again, ":cam0")), 1e-9)
            << example.name << " by " << first.name << " and " << second.name;
      }
    }
  }
  using Names = std::set<std::string>;
  const Names polynomial{
      "pinhole", "brown", "brown_4", "brown8", "kannala_brandt_160", "kannala_brandt_narrow"};
  EXPECT_EQ(holds["ros"], polynomial);
  EXPECT_EQ(holds["opencv"], polynomial);
  EXPECT_EQ(holds["kalibr"], (Names{"pinhole", "brown_4", "kannala_brandt_160", "kannala_brandt_narrow"}));
  EXPECT_EQ(holds["visp"], (Names{"pinhole", "visp_barrel", "visp_pincushion", "kannala_brandt_160",
                                  "kannala_brandt_narrow"}));
}

TEST_F(CameraFormats, KalibrSaysWhyItCannotHoldFiveCoefficients) {
  const Camera camera(camera_parameters(LensModel::brown, 533, {-0.28, 0.05, 1e-3, -5e-4, 0.0946}));
  try {
    camera_file_text(camera, camera_file_format("kalibr", ""), "");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("k3 = 0.0946"), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("radtan"), std::string::npos) << error.what();
  }
}

// ------------------------------------------------------------------------------------------------ OpenCV

TEST_F(CameraFormats, OpenCVReadsWhatWeWriteAndProjectsAlike) {
  for (const auto& example : examples()) {
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

TEST_F(CameraFormats, OpenCVsOwnFilesWithEveryNumberOfCoefficients) {
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

TEST_F(CameraFormats, OpenCVsFisheye) {
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

TEST_F(CameraFormats, OpenCVInTheSpellingsOfItsOtherPrograms) {
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

TEST_F(CameraFormats, OpenCVFaults) {
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

TEST_F(CameraFormats, OpenCVsXmlIsRefusedByName) {
  const std::string faults = faults_of("<?xml version=\"1.0\"?>\n<opencv_storage>\n</opencv_storage>\n");
  EXPECT_NE(faults.find("OpenCV"), std::string::npos) << faults;
}

// ------------------------------------------------------------------------------------------------ Kalibr

const char* const two_cameras = R"(cam0:
  cam_overlaps: [1]
  camera_model: pinhole
  distortion_coeffs: [-0.28, 0.05, 1.0e-03, -5.0e-04]
  distortion_model: radtan
  intrinsics: [458.5, 457.25, 367.125, 248.375]
  resolution: [752, 480]
  rostopic: /cam0/image_raw
cam1:
  T_cn_cnm1:
  - [0.99999, 0.0023, 0.0003, -0.11]
  - [-0.0023, 0.9998, 0.0140, 0.0004]
  - [-0.0003, -0.0140, 0.9999, -0.0008]
  - [0.0, 0.0, 0.0, 1.0]
  cam_overlaps: [0]
  camera_model: pinhole
  distortion_coeffs: [0.0034, 0.0007, -0.0003, 0.0001]
  distortion_model: equidistant
  intrinsics: [190.5, 190.25, 254.5, 256.5]
  resolution: [512, 512]
  rostopic: /cam1/image_raw
  timeshift_cam_imu: 0.001
)";

std::string one_camera() {
  return std::string(two_cameras).substr(0, std::string(two_cameras).find("cam1:\n"));
}

TEST_F(CameraFormats, KalibrsCamerasByName) {
  const CameraParameters left = read(two_cameras, ":cam0").parameters();
  EXPECT_EQ(left.model, LensModel::brown);
  EXPECT_EQ(left.coefficients[3], -5e-4);
  EXPECT_EQ(left.coefficients[4], 0);
  EXPECT_EQ(left.fx_px, 458.5);
  EXPECT_EQ(left.cy_px, 248.375);
  EXPECT_EQ(left.size, (ImageSize{752, 480}));
  const CameraParameters right = read(two_cameras, ":cam1").parameters();
  EXPECT_EQ(right.model, LensModel::kannala_brandt);
  EXPECT_EQ(right.fy_px, 190.25);
  const std::string several = faults_of(two_cameras);
  EXPECT_NE(several.find("cam0, cam1"), std::string::npos) << several;
  EXPECT_NE(faults_of(two_cameras, ":cam2").find("cam0, cam1"), std::string::npos);
  EXPECT_EQ(read(one_camera()).parameters().fx_px, 458.5);
  std::string none = replaced(one_camera(), "radtan", "none");
  none = replaced(none, "[-0.28, 0.05, 1.0e-03, -5.0e-04]", "[]");
  EXPECT_EQ(read(none).parameters().model, LensModel::pinhole);
}

TEST_F(CameraFormats, KalibrsOtherModelsAreRefusedByName) {
  for (const char* model : {"omni", "ds", "eucm"}) {
    std::string text =
        replaced(one_camera(), "camera_model: pinhole", fmt::format("camera_model: {}", model));
    text = replaced(text, "[458.5,", "[0.9, 458.5,");
    const std::string faults = faults_of(text);
    EXPECT_NE(faults.find(fmt::format("camera_model: found {};", model)), std::string::npos) << faults;
    EXPECT_EQ(std::count(faults.begin(), faults.end(), '\n'), 1) << faults;
  }
  std::string fov = replaced(one_camera(), "radtan", "fov");
  fov = replaced(fov, "[-0.28, 0.05, 1.0e-03, -5.0e-04]", "[0.9]");
  const std::string faults = faults_of(fov);
  EXPECT_NE(faults.find("distortion_model: found fov;"), std::string::npos) << faults;
  EXPECT_EQ(std::count(faults.begin(), faults.end(), '\n'), 1) << faults;
}

TEST_F(CameraFormats, KalibrFaults) {
  const std::vector<std::pair<std::string, std::string>> changes{
      {"[458.5, ", "["},
      {"[458.5, ", "[.nan, "},
      {"[458.5, ", "[-458.5, "},
      {"[458.5, ", "[wide, "},
      {"[752, 480]", "[752]"},
      {"[752, 480]", "[752.5, 480]"},
      {"[752, 480]", "[0, 480]"},
      {"[752, 480]", "752"},
      {"-5.0e-04]", "-5.0e-04, 0.1]"},
      {", -5.0e-04]", "]"},
      {"radtan", "none"},
      {"radtan", "plumb_bob"},
      {"  camera_model: pinhole\n", ""},
      {"distortion_coeffs", "distortion_coefficients"},
      {"rostopic", "topic"},
      {"cam0:\n", "cam0:\ncam0:\n"},
      {"cam0:\n", "cam0: 3\ncamera:\n"},
  };
  for (const auto& [what, with] : changes)
    EXPECT_NE(faults_of(replaced(one_camera(), what, with)), "") << what << " -> " << with;
  EXPECT_NE(faults_of(one_camera() + "camera2: 3\n"), "");
}

TEST_F(CameraFormats, KalibrAndRosNumbersAreFloatsToPython) {
  // PyYAML takes 535 for an integer, which Kalibr refuses as a focal length, and 1e-05 for a text.
  const Camera camera(camera_parameters(LensModel::brown, 500, {-0.25, 1e-5, 1e-3, -5e-14, 0}));
  for (const char* format : {"kalibr", "ros"}) {
    const std::string text = camera_file_text(camera, camera_file_format(format, ""), "");
    EXPECT_NE(text.find("[500.0, "), std::string::npos) << text;
    EXPECT_NE(text.find(", 1.0e-05, "), std::string::npos) << text;
    EXPECT_NE(text.find("-5.0e-14"), std::string::npos) << text;
  }
}

// --------------------------------------------------------------------------------------------------- ROS

/// What a shell command prints; empty if it fails.
std::string output_of(const std::string& command) {
  std::string text;
  FILE* pipe = popen((command + " 2>/dev/null").c_str(), "r");
  if (!pipe) return "";
  char buffer[4096];
  for (std::size_t n; (n = fread(buffer, 1, sizeof buffer, pipe)) > 0;) text.append(buffer, n);
  return pclose(pipe) == 0 ? text : "";
}

TEST_F(CameraFormats, RosReadsWhatWeWrite) {
  const std::string python = "/usr/bin/python3 -c ";
  if (output_of(python + "'import camera_calibration_parsers; print(1)'").empty())
    GTEST_SKIP() << "Debian's package python3-camera-calibration-parsers is not installed";
  for (const auto& example : examples()) {
    const CameraParameters& p = example.parameters;
    if (p.model == LensModel::visp) continue;
    const std::string name =
        file(example.name + ".yaml", camera_file_text(Camera(p), camera_file_format("ros", ""), "eye"));
    const std::string text = output_of(
        python +
        "'import sys, json, camera_calibration_parsers as c; name, i = c.readCalibration(sys.argv[1]);"
        " print(json.dumps([name, i.width, i.height, i.distortion_model, list(i.K), list(i.D)]))' " +
        name);
    ASSERT_FALSE(text.empty()) << example.name;
    const auto json = nlohmann::json::parse(text);
    EXPECT_EQ(json[0], "eye");
    EXPECT_EQ(json[1], 640);
    EXPECT_EQ(json[2], 480);
    const std::map<LensModel, std::string> names{{LensModel::pinhole, "plumb_bob"},
                                                 {LensModel::brown, "plumb_bob"},
                                                 {LensModel::brown8, "rational_polynomial"},
                                                 {LensModel::kannala_brandt, "equidistant"}};
    EXPECT_EQ(json[3], names.at(p.model));
    EXPECT_EQ(json[4], (std::vector<double>{p.fx_px, 0, p.cx_px, 0, p.fy_px, p.cy_px, 0, 0, 1}));
    const auto coefficients = json[5].get<std::vector<double>>();
    EXPECT_EQ(coefficients.size(), p.model == LensModel::brown8           ? 8u
                                   : p.model == LensModel::kannala_brandt ? 4u
                                                                          : 5u);
    for (std::size_t i = 0; i < coefficients.size(); ++i) EXPECT_EQ(coefficients[i], p.coefficients[i]);
  }
}

TEST_F(CameraFormats, RosCountsOfCoefficients) {
  const std::string five =
      camera_file_text(Camera(camera_parameters(LensModel::brown, 500, {-0.25, 0.1, 1e-3, -5e-4, 0.5})),
                       camera_file_format("ros", ""), "");
  std::string four = replaced(replaced(five, "cols: 5", "cols: 4"), ", 0.5]", "]");
  EXPECT_EQ(read(four).parameters().coefficients[4], 0);
  EXPECT_NE(faults_of(replaced(five, ", 0.5]", "]")), "");
  EXPECT_NE(faults_of(replaced(five, "cols: 5", "cols: 4")), "");
  EXPECT_NE(
      faults_of(replaced(replaced(five, "cols: 5", "cols: 12"), ", 0.5]", ", 0.5, 0, 0, 0, 0, 0, 0, 0]")),
      "");
}

}  // namespace
}  // namespace ballservo
