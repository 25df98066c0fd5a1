#include "app/io/free_memory.hpp"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <limits>
#include <string>

namespace ballservo {
namespace {

constexpr double no_limit = std::numeric_limits<double>::infinity();

/// The number that follows a word (or nothing) in a file of the kernel's.
double number_in(const char* file, const std::string& word, double otherwise) {
  std::ifstream stream(file);
  double number = 0;
  for (std::string name; word != name && stream >> name;) {
  }
  return stream >> number ? number : otherwise;
}

}  // namespace

double free_memory_bytes() {
  const double machine = number_in("/proc/meminfo", "MemAvailable:", no_limit) * 1024;
  const double group = number_in("/sys/fs/cgroup/memory.max", "", no_limit) -
                       number_in("/sys/fs/cgroup/memory.current", "", 0);
  rlimit limit{};
  double process = no_limit;
  if (getrlimit(RLIMIT_AS, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY)
    process = static_cast<double>(limit.rlim_cur) -
              number_in("/proc/self/statm", "", 0) * static_cast<double>(sysconf(_SC_PAGESIZE));
  return std::max(0.0, std::min({machine, group, process}));
}

}  // namespace ballservo
