#pragma once

#include <system_error>

namespace dccast::jobs {

/// Whether an error of the system is one of memory: threads and mappings need it, too.
inline bool is_memory_fault(const std::error_code& code) {
  return code == std::errc::not_enough_memory ||
         code == std::errc::resource_unavailable_try_again;
}

// Exit codes by which a worker names the resource that kept it from ending its run in good order.
inline constexpr int exit_out_of_memory = 71;
inline constexpr int exit_storage = 74;

inline constexpr const char* out_of_memory_text =
    "the worker could get no more memory: make the mesh coarser, run fewer workers at once, or "
    "give it more (ulimit -v, the limit of the container)";

}  // namespace dccast::jobs
