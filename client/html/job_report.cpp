#include "client/html/job_report.hpp"

#include <algorithm>
#include <cmath>
#include <ostream>

#include "client/html/report_page.hpp"
#include "client/session/jobs.hpp"
#include "client/session/queries.hpp"
#include "client/session/studies.hpp"

namespace dccast::client::render {
namespace {

/// The result with the last frame; without it if there is none, if it is too large for a response,
/// or if the stored results cannot be read.
v1::QueryResultResponse result_of(Connection& connection, const std::string& id,
                                  std::ostream& notes) {
  v1::QueryResultResponse result;
  const grpc::Status status = try_query_result(connection, id, true, result);
  if (status.ok()) return result;
  notes << "dccast: " << status.error_message()
        << "; the report goes without a picture of the slab\n";
  return query_result(connection, id);
}

/// Number of frames that keep the page small enough to be passed on: half a megabyte.
FrameSeries frames_for_slider(Connection& connection, const std::string& id,
                              const v1::QueryResultResponse& result) {
  constexpr int most_frames = 25;
  constexpr double most_bytes = 500e3;
  if (!result.has_frame()) return {};
  // The slab grows: a frame has half the last one's nodes on average, and of a quarter slab it is
  // the surface that counts. Eleven characters a node.
  const double nodes = result.frame().temperature_c_size();
  const double seen = result.frame().dimension() == 3 ? 6.0 * std::pow(nodes, 2.0 / 3.0) : nodes;
  const int fitting = static_cast<int>(most_bytes / (0.5 * 11.0 * seen + 1.0));
  return fetch_frames(connection, id, result, std::clamp(fitting, 2, most_frames));
}

}  // namespace

std::string report_of(Connection& connection, const v1::Job& job, std::ostream& notes) {
  const v1::QueryResultResponse result = result_of(connection, job.id(), notes);
  return report_page(job, result, study_around(connection, job),
                     frames_for_slider(connection, job.id(), result));
}

}  // namespace dccast::client::render
