#include "client/frame_fetch.hpp"

namespace dccast::client {

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
