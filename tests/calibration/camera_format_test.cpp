// Every format against every other, Kalibr's own files, and ROS' own reader.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdio>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "tests/calibration/camera_format_fixture.hpp"

namespace ballservo {
namespace {

using test::camera_parameters;
using test::CameraFormats;
using test::format_examples;
using test::largest_difference_px;
using test::replaced;

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

TEST_F(CameraFormats, FromEachToEachWithoutLoss) {
  std::map<std::string, std::set<std::string>> holds;
  for (const auto& example : format_examples()) {
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
  const std::string fault =
      test::fault_lines([&] { camera_file_text(camera, camera_file_format("kalibr", ""), ""); });
  EXPECT_NE(fault.find("k3 = 0.0946"), std::string::npos) << fault;
  EXPECT_NE(fault.find("radtan"), std::string::npos) << fault;
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
  for (const auto& example : format_examples()) {
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
