// The size of a picture.
#pragma once

namespace ballservo {

struct ImageSize {
  int width_px = 0;
  int height_px = 0;

  friend bool operator==(const ImageSize& a, const ImageSize& b) {
    return a.width_px == b.width_px && a.height_px == b.height_px;
  }
  friend bool operator!=(const ImageSize& a, const ImageSize& b) { return !(a == b); }
};

}  // namespace ballservo
