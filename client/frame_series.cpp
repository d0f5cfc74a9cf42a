#include "client/frame_series.hpp"

#include <algorithm>
#include <cmath>

namespace dccast::client {

std::vector<int> evenly_chosen(int stored, int most) {
  std::vector<int> numbers;
  const int count = std::min(stored, most);
  for (int i = 0; i + 1 < count; ++i)
    numbers.push_back(1 + static_cast<int>(std::lround(double(i) * (stored - 1) / (count - 1))));
  if (count > 0) numbers.push_back(stored);
  return numbers;
}

}  // namespace dccast::client
