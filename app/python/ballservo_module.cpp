// What `import ballservo` brings: the library's parts over numpy arrays.
#include "app/python/bindings.hpp"
#include "calibration/base/fault.hpp"

namespace ballservo {

cv::Mat picture_of(const py::array& bgr) {
  const bool pixels = bgr.dtype().kind() == 'u' && bgr.itemsize() == 1 && bgr.ndim() == 3 &&
                      bgr.shape(2) == 3 && bgr.shape(0) > 0 && bgr.shape(1) > 0 && bgr.shape(0) <= 65536 &&
                      bgr.shape(1) <= 65536;
  if (!pixels)
    throw InputError("bgr",
                     py::str("an array of {} {}").format(bgr.dtype(), bgr.attr("shape")).cast<std::string>(),
                     "uint8 of shape (height, width, 3), in the order blue, green, red");
  const py::ssize_t row = 3 * bgr.shape(1);
  if (bgr.strides(2) != 1 || bgr.strides(1) != 3 || (bgr.shape(0) > 1 && bgr.strides(0) < row))
    throw InputError(
        "bgr", py::str("strides of {} bytes").format(bgr.attr("strides")).cast<std::string>(),
        "rows of pixels side by side, from the top down; numpy.ascontiguousarray(bgr) copies such "
        "a view");
  return cv::Mat(static_cast<int>(bgr.shape(0)), static_cast<int>(bgr.shape(1)), CV_8UC3,
                 const_cast<void*>(bgr.data()),
                 static_cast<std::size_t>(bgr.shape(0) > 1 ? bgr.strides(0) : row));
}

py::object python_of(const std::string& json) { return py::module_::import("json").attr("loads")(json); }

py::object columns_of(const std::string& csv) {
  return py::module_::import("ballservo.tables").attr("columns")(csv);
}

/// A message of the command line, its options named as arguments of Python are.
std::string as_arguments(std::string message) {
  const std::string force = "--force";
  for (std::size_t at = 0; (at = message.find("--", at)) != std::string::npos;) {
    const bool names = at + 2 < message.size() && std::islower(static_cast<unsigned char>(message[at + 2]));
    if (message.compare(at, force.size(), force) == 0)
      message.replace(at, force.size(), "overwrite=True");
    else if (names)
      message.erase(at, 2);
    else
      at += 2;
  }
  return message;
}

PYBIND11_MODULE(_ballservo, module) {
  module.doc() =
      "The library's parts over numpy arrays. Metres, seconds, radians and pixels; camera frame x right, y "
      "down, z forward.";
  static py::exception<InputError> input_error(module, "InputError", PyExc_ValueError);
  input_error.attr("__doc__") =
      "Bad input: every fault, one a line, with its place, what was found and what is allowed.";
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const InputError& error) {
      input_error(as_arguments(error.what()).c_str());
    } catch (const Refusal& refusal) {
      PyErr_SetString(PyExc_RuntimeError, refusal.what());
    } catch (const Interrupted&) {
      PyErr_SetNone(PyExc_KeyboardInterrupt);
    }
  });

  add_seeing(module);
  add_scenarios(module);
  add_driving(module);
  add_studies(module);
}

}  // namespace ballservo
