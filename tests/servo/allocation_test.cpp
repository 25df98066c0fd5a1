// After warm-up a control step of law cone takes no memory from the heap. Counted below operator new, where
// Eigen and the C library allocate too.
#include <gtest/gtest.h>

#include <atomic>
#include <cerrno>
#include <cstddef>

#include "servo/controller.hpp"

namespace {
std::atomic<long> allocations{0};
}

extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);

void* malloc(std::size_t size) {
  ++allocations;
  return __libc_malloc(size);
}
void* calloc(std::size_t count, std::size_t size) {
  ++allocations;
  return __libc_calloc(count, size);
}
void* realloc(void* old, std::size_t size) {
  ++allocations;
  return __libc_realloc(old, size);
}
int posix_memalign(void** result, std::size_t alignment, std::size_t size) {
  ++allocations;
  *result = __libc_memalign(alignment, size);
  return *result == nullptr ? ENOMEM : 0;
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
  ++allocations;
  return __libc_memalign(alignment, size);
}
}

namespace ballservo {
namespace {

long allocations_of_run(const std::string& law) {
  ControllerOptions options;
  options.law.name = law;
  Controller controller(options);
  long before = 0;
  for (int k = 0; k < 1500; ++k) {
    if (k == 300) before = allocations;
    BallMeasurement frame;
    frame.time_s = 0.02 * k;
    // Seen, lost, seen again; frames missing altogether for a while.
    frame.state = k % 400 < 300 ? TrackState::confirmed : TrackState::none;
    frame.p_CB = {0.3, 0.1, 3.0};
    frame.covariance_m2 = 1e-4 * Eigen::Matrix3d::Identity();
    if (k % 700 < 650) controller.see(frame);
    controller.step(0.02 * k, {}, {0.1, 0.0});
  }
  return allocations - before;
}

TEST(Allocation, ControlStepTakesNoMemory) { EXPECT_EQ(allocations_of_run("cone"), 0); }

TEST(Allocation, TheCounterCounts) { EXPECT_GT(allocations_of_run("visp"), 0); }

}  // namespace
}  // namespace ballservo
