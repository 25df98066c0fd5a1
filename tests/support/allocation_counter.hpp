// Counts what a program takes from the heap, below operator new, where Eigen, OpenCV and the C library
// allocate too. For executables that link the object library `allocation_counter`; not under sanitizers,
// which bring a malloc of their own.
#pragma once

namespace ballservo::test {

/// Calls of malloc, calloc, realloc, posix_memalign and aligned_alloc so far.
long allocations();

}  // namespace ballservo::test
