// What the tests of the camera formats share.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <string>
#include <vector>

#include "calibration/base/fault.hpp"
#include "calibration/camera/files/camera_file.hpp"
#include "tests/calibration/camera_examples.hpp"
#include "tests/support/faults.hpp"
#include "tests/support/test_data.hpp"

namespace ballservo::test {

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
    return fault_lines([&] { read(contents, camera_name); });
  }
  TemporaryFolder folder_;
};

inline std::string replaced(std::string text, const std::string& what, const std::string& with) {
  const auto at = text.find(what);
  EXPECT_NE(at, std::string::npos) << what;
  return text.replace(at, what.size(), with);
}

/// Cameras of every model, and one whose brown lens has four coefficients.
inline std::vector<CameraExample> format_examples() {
  auto list = camera_examples();
  list.push_back({"brown_4", camera_parameters(LensModel::brown, 533, {-0.2845, 0.0565, 1e-5, -5e-7, 0})});
  return list;
}

/// The largest distance (px) at which two cameras see the same point of the first one's pixels.
inline double largest_difference_px(const Camera& a, const Camera& b) {
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

}  // namespace ballservo::test
