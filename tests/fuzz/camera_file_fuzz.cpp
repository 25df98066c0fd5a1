// Camera files of all formats: an InputError, or a camera that can be written and read back the same.
#include "calibration/base/fault.hpp"
#include "calibration/camera/files/camera_file.hpp"
#include "tests/fuzz/fuzz_folder.hpp"

using namespace ballservo;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const fuzz::Folder folder(BALLSERVO_DATA_DIR);
  try {
    const Camera camera = read_camera(folder.file("camera", fuzz::text_of(data, size)).string());
    const CameraParameters& p = camera.parameters();
    const auto ray = camera.unproject({p.cx_px, p.cy_px});
    if (ray) fuzz::require(ray->allFinite(), "a finite ray");
    for (const CameraFileFormat& format : camera_file_formats()) {
      if (format.name == "visp") continue;  // ViSP's writer needs a folder of its own each time
      std::string text;
      try {
        text = camera_file_text(camera, format, "cam0");
      } catch (const InputError&) {
        continue;  // a model that this format does not hold
      }
      const CameraParameters back = read_camera(folder.file("again", text).string()).parameters();
      fuzz::require(back.size == p.size && back.fx_px == p.fx_px && back.cy_px == p.cy_px &&
                        back.coefficients == p.coefficients,
                    "a camera that reads back as it was written");
    }
  } catch (const InputError&) {
  }
  return 0;
}
