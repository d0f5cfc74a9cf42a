#include "client/job_result.hpp"

namespace dccast::client {
namespace {

/// All pages from the first on. A page adds steps; the case and the frame come with the first.
grpc::Status read_pages(Connection& connection, v1::QueryResultRequest request,
                        v1::QueryResultResponse& result) {
  result.Clear();
  while (true) {
    v1::QueryResultResponse page;
    const grpc::Status status = connection.try_call(&Stub::QueryResult, request, page);
    if (!status.ok()) return status;
    result.MergeFrom(page);
    if (page.next_page_token().empty()) return status;
    if (page.next_page_token() == request.page_token())
      return {grpc::StatusCode::INTERNAL, "the server repeats a page of the history"};
    request.set_page_token(page.next_page_token());
  }
}

}  // namespace

grpc::Status try_query_result(Connection& connection, const std::string& id, bool frame,
                              v1::QueryResultResponse& result) {
  constexpr int readings = 5;  // a worker is restarted less often than that in one reading
  v1::QueryResultRequest request;
  request.set_id(id);
  request.set_frame(frame);
  grpc::Status status;
  for (int reading = 0; reading < readings; ++reading) {
    status = read_pages(connection, request, result);
    if (status.error_code() != grpc::StatusCode::ABORTED) break;
  }
  result.clear_next_page_token();
  return status;
}

v1::QueryResultResponse query_result(Connection& connection, const std::string& id) {
  v1::QueryResultResponse result;
  check(try_query_result(connection, id, false, result), connection.server());
  return result;
}

}  // namespace dccast::client
