#include <fcntl.h>

#include <optional>

#include "server/service/file_stream.hpp"
#include "server/service/status.hpp"
#include "server/service/streams.hpp"

namespace dccast::service {

namespace {

std::optional<v1::Artifact> artifact_of(const v1::Job& job, const std::string& name) {
  for (const v1::Artifact& artifact : job.artifacts())
    if (artifact.name() == name) return artifact;
  return std::nullopt;
}

grpc::Status open_artifact(Context& context, const v1::FetchResultRequest& request,
                           SentFile& sent) {
  if (const auto status = check_id(request.id()); !status.ok()) return status;
  const auto job = context.scheduler.find(request.id());
  if (!job) return job_not_found(request.id());
  if (job->artifacts().empty())
    return wrong_state(*job, "it has no results yet: watch it until it has ended");
  const std::string name = request.artifact().empty() ? "results.h5" : request.artifact();
  const auto artifact = artifact_of(*job, name);
  if (!artifact)
    return {grpc::StatusCode::NOT_FOUND,
            "job " + request.id() + " has no result \"" + name + "\"; GetJob lists them"};
  sent = {.file = storage::File(context.jobs_directory / request.id() / name, O_RDONLY),
          .name = name,
          .size = artifact->size_bytes(),
          .sha256 = artifact->sha256()};
  if (sent.file.size() == sent.size) return grpc::Status::OK;
  return {grpc::StatusCode::DATA_LOSS,
          name + " on the server has not the size its worker wrote; run the job again"};
}

}  // namespace

grpc::ServerWriteReactor<v1::FetchResultResponse>* fetch_result(
    Context& context, WorkPool& lane, const StreamCall& call,
    const v1::FetchResultRequest& request) {
  return send_file(lane, call, request.offset(), [&context, request](const Call&, SentFile& sent) {
    return open_artifact(context, request, sent);
  });
}

}  // namespace dccast::service
