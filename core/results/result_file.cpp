#include "core/results/result_file.hpp"

#include <cstdio>

namespace dccast::results {

std::string frame_group(std::size_t index) {
  char name[40];
  std::snprintf(name, sizeof name, "/frames/%06zu", index);
  return name;
}

}  // namespace dccast::results
