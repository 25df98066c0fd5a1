// The covariance beside a camera file.
#include "calibration/base/fault.hpp"
#include "calibration/camera/files/camera_covariance.hpp"
#include "tests/fuzz/fuzz_folder.hpp"

using namespace ballservo;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const fuzz::Folder folder(BALLSERVO_DATA_DIR);
  // The camera that the seed was written for.
  static const Camera camera(CameraParameters{LensModel::pinhole, {640, 480}, 500, 500, 320, 240, {}});
  folder.file("camera.yaml.covariance.json", fuzz::text_of(data, size));
  try {
    if (const auto known = read_camera_covariance((folder.inputs() / "camera.yaml").string(), camera))
      fuzz::require(known->allFinite() && known->rows() == 4, "a covariance of the camera");
  } catch (const InputError&) {
  }
  return 0;
}
