#include "perception/classification.hpp"

namespace ballservo {

void classify(const cv::Mat& bgr, const ColorTable& table, cv::Mat& classes) {
  CV_Assert(bgr.type() == CV_8UC3);
  classes.create(bgr.size(), CV_8UC1);
  const ClassIndex* const entries = table.table.data();
  for (int v = 0; v < bgr.rows; ++v) {
    const std::uint8_t* in = bgr.ptr<std::uint8_t>(v);
    ClassIndex* out = classes.ptr<ClassIndex>(v);
    for (int u = 0; u < bgr.cols; ++u, in += 3) out[u] = entries[ColorTable::index(in[0], in[1], in[2])];
  }
}

}  // namespace ballservo
