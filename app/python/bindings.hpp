// What the parts of the module share.
#pragma once

#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <chrono>
#include <future>
#include <opencv2/core.hpp>
#include <string>
#include <utility>

#include "app/io/interrupt.hpp"
#include "calibration/camera/sphere_outline.hpp"
#include "servo/motion/unicycle.hpp"

namespace ballservo {

namespace py = pybind11;
using Path = std::filesystem::path;

/// Camera, Colors, Ball, Detector, Tracker.
void add_seeing(py::module_& module);
/// Scenario.
void add_scenarios(py::module_& module);
/// Run, simulate and what they give.
void add_driving(py::module_& module);
/// calibrate_camera, sweep, compare.
void add_studies(py::module_& module);

/// The picture where it lies. A view that OpenCV cannot look at is refused: nothing is copied unasked.
/// `gray`: one channel will do.
cv::Mat picture_of(const py::array& array, const std::string& name = "bgr", bool gray = false);

/// x_m, y_m, yaw_rad.
inline Eigen::Vector3d array_of(const Pose2& pose) { return {pose.x_m, pose.y_m, pose.yaw_rad}; }
/// The centre and the radius.
inline Eigen::Vector3d array_of(const OutlineEllipse& outline) {
  return {outline.center_px.x(), outline.center_px.y(), outline.radius_px};
}

py::object python_of(const std::string& json);
/// A CSV file's columns by name (tables.py).
py::object columns_of(const std::string& csv);

/// Does the work on a thread of its own, without the interpreter: this thread hears Ctrl-C meanwhile, if it
/// is Python's main thread, and interrupts the work (interrupt.hpp).
template <class Work>
auto hearing_ctrl_c(Work&& work) {
  const py::gil_scoped_release released;
  auto done = std::async(std::launch::async, std::forward<Work>(work));
  while (done.wait_for(std::chrono::milliseconds(20)) == std::future_status::timeout) {
    const py::gil_scoped_acquire held;
    if (PyErr_CheckSignals() == 0) continue;
    py::error_already_set heard;
    const py::gil_scoped_release waiting;
    request_interrupt(true);
    done.wait();
    request_interrupt(false);
    throw heard;
  }
  return done.get();
}

}  // namespace ballservo
