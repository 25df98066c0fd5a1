// How much memory is left for a run.
#pragma once

namespace ballservo {

/// Bytes that this process can still have: of the machine, of its control group, of the user's limit.
double free_memory_bytes();

}  // namespace ballservo
