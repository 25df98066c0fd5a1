// What detect and track say of pictures that had too much of the balls' colours.
#pragma once

#include <string>

#include "perception/detector.hpp"

namespace ballservo {

class LeftOutWarning {
 public:
  void add(const LeftOut& left_out, const std::string& source, long frame);
  /// One warning for all pictures, with the first of them as example; nothing where none had.
  void say() const;

 private:
  long pictures_ = 0;
  std::string example_;
};

}  // namespace ballservo
