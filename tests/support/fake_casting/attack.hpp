#pragma once

#include <string>

namespace dccast::casting {

/// Does what a worker would do that a file has taken over: tries to end, stop or change its daemon,
/// and to take `bytes` of memory past its bound. @return what worked, a line each; empty for
/// nothing
std::string attack(std::size_t bytes);

}  // namespace dccast::casting
