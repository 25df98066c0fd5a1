// What `import ballservo` brings: the library's parts over numpy arrays.
#include "app/python/bindings.hpp"
#include "calibration/base/fault.hpp"

namespace ballservo {

cv::Mat picture_of(const py::array& array, const std::string& name, bool gray) {
  const bool one = gray && array.ndim() == 2;
  const bool pixels = array.dtype().kind() == 'u' && array.itemsize() == 1 &&
                      (one || (array.ndim() == 3 && array.shape(2) == 3)) && array.shape(0) > 0 &&
                      array.shape(1) > 0 && array.shape(0) <= 65536 && array.shape(1) <= 65536;
  if (!pixels)
    throw InputError(
        name, py::str("an array of {} {}").format(array.dtype(), array.attr("shape")).cast<std::string>(),
        std::string("uint8 of shape (height, width, 3), in the order blue, green, red") +
            (gray ? ", or (height, width)" : ""));
  const py::ssize_t pixel = one ? 1 : 3, row = pixel * array.shape(1);
  if ((!one && array.strides(2) != 1) || array.strides(1) != pixel ||
      (array.shape(0) > 1 && array.strides(0) < row))
    throw InputError(
        name, py::str("strides of {} bytes").format(array.attr("strides")).cast<std::string>(),
        "rows of pixels side by side, from the top down; numpy.ascontiguousarray copies such a view");
  return cv::Mat(static_cast<int>(array.shape(0)), static_cast<int>(array.shape(1)), one ? CV_8UC1 : CV_8UC3,
                 const_cast<void*>(array.data()),
                 static_cast<std::size_t>(array.shape(0) > 1 ? array.strides(0) : row));
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

/// An object that `Class.__new__(Class)` made has no C++ object. Where one is asked for,
/// pybind11 would take memory for it and use it as it is.
void refuse_objects_without_init(const py::module_& module) {
  for (const auto& [name, object] : module.attr("__dict__").cast<py::dict>()) {
    if (!py::isinstance<py::type>(object)) continue;
    auto* const info = py::detail::get_type_info(reinterpret_cast<PyTypeObject*>(object.ptr()));
    if (info == nullptr) continue;
    info->operator_new = [](std::size_t) -> void* {
      throw py::type_error("an object that was never made: call its class");
    };
  }
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
  refuse_objects_without_init(module);
}

}  // namespace ballservo
