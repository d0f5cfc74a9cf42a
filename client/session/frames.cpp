#include "client/session/frames.hpp"

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

FrameSeries fetch_frames(Connection& connection, const std::string& id,
                         const v1::QueryResultResponse& last, int most) {
  FrameSeries series{.stored = last.frame_time_s_size(), .frames = {}};
  v1::QueryResultRequest request;
  request.set_id(id);
  request.set_frame(true);
  request.set_page_size(1);
  for (const int number : evenly_chosen(series.stored, most)) {
    request.set_frame_number(number);
    series.frames.push_back(number == series.stored
                                ? last.frame()
                                : connection.call(&Stub::QueryResult, request).frame());
  }
  return series;
}

}  // namespace dccast::client
