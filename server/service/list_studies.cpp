#include <algorithm>

#include "server/jobs/events.hpp"
#include "server/service/age_token.hpp"
#include "server/service/study_handlers.hpp"

namespace dccast::service {

namespace {

constexpr int default_page = 50;
constexpr int largest_page = 1000;

}  // namespace

grpc::Status list_studies(StudyContext& context, const Call&, const v1::ListStudiesRequest& request,
                          v1::ListStudiesResponse& response) {
  studies::StudyStore::Page page;
  if (!read_age_token(request.page_token(), page.before_ms, page.before_id))
    return {grpc::StatusCode::INVALID_ARGUMENT,
            "the page_token is not one of ListStudies; begin again without it"};
  if (request.page_size() < 0)
    return {grpc::StatusCode::INVALID_ARGUMENT, "page_size must not be negative"};
  const int size =
      request.page_size() == 0 ? default_page : std::min(request.page_size(), largest_page);
  page.size = size + 1;  // one more tells whether there is a next page
  auto studies = context.studies.list(page);
  const bool more = static_cast<int>(studies.size()) > size;
  if (more) studies.pop_back();
  for (v1::Study& study : studies) *response.add_studies() = std::move(study);
  if (!more) return grpc::Status::OK;
  const v1::Study& last = response.studies(size - 1);
  response.set_next_page_token(age_token(jobs::milliseconds(last.create_time()), last.id()));
  return grpc::Status::OK;
}

}  // namespace dccast::service
