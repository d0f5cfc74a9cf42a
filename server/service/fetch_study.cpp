#include <fcntl.h>
#include <unistd.h>

#include "proto/values/digests.hpp"
#include "server/service/file_stream.hpp"
#include "server/service/status.hpp"
#include "server/service/study_handlers.hpp"
#include "server/service/study_status.hpp"

namespace dccast::service {

namespace {

/// A path that is free, and is free again afterwards.
class PassingFile {
public:
  explicit PassingFile(const std::filesystem::path& folder)
      : path_(folder / (values::random_uuid() + ".h5")) {}
  PassingFile(const PassingFile&) = delete;
  ~PassingFile() { ::unlink(path_.c_str()); }
  const std::filesystem::path& path() const { return path_; }

private:
  std::filesystem::path path_;
};

/// The study as a file that has no name any more: it is gone with the call. A study that has not
/// changed gives the same bytes, so that a client goes on where it was.
grpc::Status open_study(StudyContext& context, const Call& call,
                        const v1::FetchStudyRequest& request, SentFile& sent) {
  if (const auto status = check_study_id(request.id()); !status.ok()) return status;
  const auto result = context.studies.evaluate(request.id(), true);
  if (!result) return study_not_found(request.id());
  const PassingFile file(context.service.query_directory);
  context.service.checkers.ask(jobs::Question::study_table,
                               file.path().string() + "\n" + result->SerializeAsString(),
                               patience(call, context.service.check_timeout));
  sent = {.file = storage::File(file.path(), O_RDONLY),
          .name = "the table of study " + request.id(),
          .sha256 = values::sha256_of_file(file.path())};
  sent.size = sent.file.size();
  if (request.sha256().empty() || request.sha256() == sent.sha256) return grpc::Status::OK;
  return {grpc::StatusCode::ABORTED, "the study went on meanwhile; begin again from 0"};
}

}  // namespace

grpc::ServerWriteReactor<v1::FetchResultResponse>* fetch_study(
    StudyContext& context, WorkPool& lane, const StreamCall& call,
    const v1::FetchStudyRequest& request) {
  return send_file(lane, call, request.offset(),
                   [&context, request](const Call& asked, SentFile& sent) {
                     return open_study(context, asked, request, sent);
                   });
}

}  // namespace dccast::service
