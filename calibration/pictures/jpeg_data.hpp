// What a JPEG picture's data hold.
#pragma once

#include <string_view>

namespace ballservo {

/// Whether the data go on to the picture's end: libjpeg makes up what is missing, and only warns of it. False
/// too for what libjpeg cannot read.
bool jpeg_data_suffice(std::string_view bytes);

}  // namespace ballservo
