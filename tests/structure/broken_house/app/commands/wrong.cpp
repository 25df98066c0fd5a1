#include <fmt/format.h>

void say() { fmt::print("a full disk ends it"); }
