#include "calibration/pictures/jpeg_data.hpp"

#include <jerror.h>
#include <jpeglib.h>

#include <csetjmp>
#include <cstdio>  // jpeglib.h wants it before

namespace ballservo {
namespace {

struct Errors {
  jpeg_error_mgr manager;  // first: libjpeg knows it alone
  std::jmp_buf on_error;
  bool data_end_early;
};

Errors& errors_of(j_common_ptr info) { return *reinterpret_cast<Errors*>(info->err); }

/// libjpeg returns from an error in no other way; nothing here has a destructor that it would leave out.
bool read_to_the_end(jpeg_decompress_struct& info, Errors& errors, std::string_view bytes) {
  if (setjmp(errors.on_error) != 0) return false;
  jpeg_create_decompress(&info);
  jpeg_mem_src(&info, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size());
  jpeg_read_header(&info, TRUE);
  info.scale_num = 1, info.scale_denom = 8;  // the least work that reads all data
  info.out_color_space = info.jpeg_color_space;
  jpeg_start_decompress(&info);
  JSAMPARRAY row =
      info.mem->alloc_sarray(reinterpret_cast<j_common_ptr>(&info), JPOOL_IMAGE,
                             info.output_width * static_cast<JDIMENSION>(info.output_components), 1);
  while (info.output_scanline < info.output_height && !errors.data_end_early)
    jpeg_read_scanlines(&info, row, 1);
  return !errors.data_end_early;
}

}  // namespace

bool jpeg_data_suffice(std::string_view bytes) {
  jpeg_decompress_struct info{};
  Errors errors{};
  info.err = jpeg_std_error(&errors.manager);
  errors.manager.error_exit = [](j_common_ptr of) { std::longjmp(errors_of(of).on_error, 1); };
  errors.manager.emit_message = [](j_common_ptr of, int level) {
    const int code = of->err->msg_code;
    if (level < 0 && (code == JWRN_HIT_MARKER || code == JWRN_JPEG_EOF)) errors_of(of).data_end_early = true;
  };
  const bool suffice = read_to_the_end(info, errors, bytes);
  jpeg_destroy_decompress(&info);
  return suffice;
}

}  // namespace ballservo
