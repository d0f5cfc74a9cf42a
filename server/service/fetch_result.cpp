#include <fcntl.h>

#include <algorithm>
#include <atomic>
#include <optional>

#include "core/storage/file.hpp"
#include "server/service/status.hpp"
#include "server/service/streams.hpp"

namespace dccast::service {

namespace {

constexpr std::int64_t chunk_size = 256 * 1024;

std::optional<v1::Artifact> artifact_of(const v1::Job& job, const std::string& name) {
  for (const v1::Artifact& artifact : job.artifacts())
    if (artifact.name() == name) return artifact;
  return std::nullopt;
}

/// Sends a file chunk by chunk; one is under way at a time.
class FetchStream final : public grpc::ServerWriteReactor<v1::FetchResultResponse> {
public:
  explicit FetchStream(Context& context) : context_(context) {}

  /// The stream lives until Finish(), which nothing else calls before the first chunk is sent.
  void begin(WorkPool& lane, const StreamCall& stream, const v1::FetchResultRequest& request) {
    const bool taken = lane.post([this, stream, request] {
      const grpc::Status status =
          guarded([&] { return open(stream.call([this] { return cancelled_.load(); }), request); });
      if (status.ok())
        send_next();
      else
        Finish(status);
    });
    if (!taken) Finish(too_many_waiting());
  }

  void OnWriteDone(bool ok) override {
    if (!ok)
      Finish(grpc::Status::CANCELLED);
    else if (next_ == chunk_.total_size_bytes())
      Finish(grpc::Status::OK);
    else
      send_next();
  }

  void OnCancel() override { cancelled_ = true; }

  void OnDone() override { delete this; }

private:
  grpc::Status open(const Call& call, const v1::FetchResultRequest& request) {
    if (const auto unwanted = no_longer_wanted(call)) return *unwanted;
    if (const auto status = check_id(request.id()); !status.ok()) return status;
    const auto job = context_.scheduler.find(request.id());
    if (!job) return job_not_found(request.id());
    if (job->artifacts().empty())
      return wrong_state(*job, "it has no results yet: watch it until it has ended");
    const std::string name = request.artifact().empty() ? "results.h5" : request.artifact();
    const auto artifact = artifact_of(*job, name);
    if (!artifact)
      return {grpc::StatusCode::NOT_FOUND,
              "job " + request.id() + " has no result \"" + name + "\"; GetJob lists them"};
    return open(*artifact, context_.jobs_directory / request.id() / name, request.offset());
  }

  grpc::Status open(const v1::Artifact& artifact, const std::filesystem::path& path,
                    std::int64_t offset) {
    if (offset < 0 || offset > artifact.size_bytes())
      return {grpc::StatusCode::OUT_OF_RANGE, artifact.name() + " has " +
                                                  std::to_string(artifact.size_bytes()) +
                                                  " bytes; begin again from 0"};
    file_ = storage::File(path, O_RDONLY);
    if (file_.size() != artifact.size_bytes())
      return {
          grpc::StatusCode::DATA_LOSS,
          artifact.name() + " on the server has not the size its worker wrote; run the job again"};
    chunk_.set_total_size_bytes(artifact.size_bytes());
    chunk_.set_sha256(artifact.sha256());
    next_ = offset;
    return grpc::Status::OK;
  }

  void send_next() {
    const auto size =
        static_cast<std::size_t>(std::min(chunk_size, chunk_.total_size_bytes() - next_));
    const grpc::Status status = guarded([&] {
      chunk_.set_offset(next_);
      chunk_.mutable_data()->resize(size);
      if (file_.read_at(next_, *chunk_.mutable_data()) == size) return grpc::Status::OK;
      return grpc::Status(grpc::StatusCode::DATA_LOSS, "the file became shorter while it was read");
    });
    if (!status.ok()) return Finish(status);
    next_ += static_cast<std::int64_t>(size);
    StartWrite(&chunk_);
  }

  Context& context_;
  std::atomic<bool> cancelled_{false};
  storage::File file_;
  v1::FetchResultResponse chunk_;
  std::int64_t next_ = 0;
};

}  // namespace

grpc::ServerWriteReactor<v1::FetchResultResponse>* fetch_result(
    Context& context, WorkPool& lane, StreamCall call, const v1::FetchResultRequest& request) {
  auto* stream = new FetchStream(context);  // deleted in OnDone
  stream->begin(lane, call, request);
  return stream;
}

}  // namespace dccast::service
