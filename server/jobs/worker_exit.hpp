#pragma once

namespace dccast::jobs {

// Exit codes by which a worker names the resource that kept it from ending its run in good order.
inline constexpr int exit_out_of_memory = 71;
inline constexpr int exit_storage = 74;

inline constexpr const char* out_of_memory_text =
    "the worker could get no more memory: make the mesh coarser, run fewer workers at once, or "
    "give it more (ulimit -v, the limit of the container)";

}  // namespace dccast::jobs
