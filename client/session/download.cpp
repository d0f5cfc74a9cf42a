#include "client/session/download.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <fmt/core.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <memory>
#include <optional>
#include <ostream>
#include <string_view>

#include "client/session/jobs.hpp"
#include "proto/values/digests.hpp"

namespace dccast::client {
namespace {

namespace fs = std::filesystem;

std::int64_t size_of(const fs::path& file) {
  std::error_code error;
  const auto size = fs::file_size(file, error);
  return error ? 0 : static_cast<std::int64_t>(size);
}

/// A stream of chunks, with its name for messages.
struct Source {
  using Reader = std::unique_ptr<grpc::ClientReaderInterface<v1::FetchResultResponse>>;
  std::string name;
  /// @param sha256  of the chunks received so far; empty if there are none
  std::function<Reader(grpc::ClientContext&, std::int64_t offset, const std::string& sha256)> open;
};

struct Attempt {
  grpc::Status status;
  std::int64_t total = -1;
  std::string sha256;
  bool received = false;  ///< something, if not all
};

CommandFailed unwritable(const fs::path& file, int error) {
  return {ExitCode::output_lost, "cannot write " + file.string() + ": " + std::strerror(error)};
}

/// A part file, written at its end. A symbolic link in its place is not followed, since others
/// who may write to the folder could have made it.
class PartFile {
public:
  explicit PartFile(const fs::path& file)
      : file_(file),
        descriptor_(
            ::open(file.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_NOFOLLOW | O_CLOEXEC, 0666)) {
    if (descriptor_ < 0 && errno == ELOOP)
      throw CommandFailed(ExitCode::not_found,
                          file.string() + " is a symbolic link; remove it, or give another -o");
    if (descriptor_ < 0) throw unwritable(file, errno);
  }
  PartFile(const PartFile&) = delete;
  ~PartFile() { ::close(descriptor_); }

  void append(std::string_view data) {
    while (!data.empty()) {
      const ssize_t written = ::write(descriptor_, data.data(), data.size());
      if (written < 0 && errno == EINTR) continue;
      if (written < 0) throw unwritable(file_, errno);
      data.remove_prefix(static_cast<std::size_t>(written));
    }
  }

private:
  fs::path file_;
  int descriptor_;
};

/// Appends the missing data to the part file.
Attempt append_rest(Connection& connection, const Source& source, const std::string& sha256,
                    const fs::path& part) {
  PartFile file(part);
  grpc::ClientContext context;
  const Interruption::Call call(connection.interruption(), context);
  // The server continues behind the bytes that are there, if the checksum is still that of its
  // file.
  const auto reader = source.open(context, size_of(part), sha256);
  Attempt attempt;
  v1::FetchResultResponse chunk;
  while (reader->Read(&chunk)) {
    file.append(chunk.data());
    attempt.received = true;
    attempt.total = chunk.total_size_bytes();
    attempt.sha256 = chunk.sha256();
  }
  attempt.status = reader->Finish();
  return attempt;
}

bool cut(const Attempt& attempt, const fs::path& part) {
  const auto code = attempt.status.error_code();
  if (code == grpc::StatusCode::UNAVAILABLE || code == grpc::StatusCode::DEADLINE_EXCEEDED)
    return true;
  return attempt.status.ok() && attempt.total >= 0 && size_of(part) < attempt.total;
}

Interrupted interrupted_at(const fs::path& part) {
  const std::int64_t bytes = size_of(part);
  if (bytes == 0) fs::remove(part);
  return Interrupted(bytes == 0 ? "nothing was fetched yet"
                                : part.string() + " keeps " + std::to_string(bytes) +
                                      " bytes; the same command goes on behind them");
}

/// Whether the data received so far belong to a different file from the present one.
bool of_another(const Attempt& attempt) {
  const auto code = attempt.status.error_code();
  return code == grpc::StatusCode::OUT_OF_RANGE || code == grpc::StatusCode::ABORTED;
}

/// A file that is being fetched, beside its final name until it is whole.
class PartialFile {
public:
  PartialFile(fs::path file, std::ostream& messages)
      : file_(std::move(file)), part_(file_.string() + ".part"), messages_(messages) {
    result_.resumed_at = size_of(part_);
    if (result_.resumed_at > 0)
      messages_ << fmt::format("fetch: going on after the {} bytes in {}", result_.resumed_at,
                               part_.string())
                << std::endl;
  }

  const fs::path& path() const { return part_; }

  /// Removes a part that does not belong to the file which the server has now.
  void begin_again() {
    messages_ << fmt::format("fetch: {} is not the beginning of this file; beginning again",
                             part_.string())
              << std::endl;
    fs::remove(part_);
    result_.resumed_at = 0;
  }

  /// Takes its final name if size and digest are those of the server's file.
  std::optional<Download> finish(const Attempt& attempt) {
    if (attempt.total != size_of(part_) || values::sha256_of_file(part_) != attempt.sha256)
      return std::nullopt;

    fs::rename(part_, file_);
    result_.bytes = attempt.total;
    result_.sha256 = attempt.sha256;
    return result_;
  }

private:
  fs::path file_, part_;
  std::ostream& messages_;
  Download result_;
};

/// Waits after a cut stream, longer each time. Attempts count from the last bytes that arrived.
class CutStreams {
public:
  void received() {
    failures_ = 0;
    pause_ = policy_.first_pause;
  }

  /// @return false: there were as many failures as the policy permits
  bool may_go_on(Connection& connection, const fs::path& part, std::ostream& messages) {
    if (++failures_ >= policy_.attempts) return false;
    messages << fmt::format("fetch: the stream was cut at byte {}, going on (attempt {} of {})",
                            size_of(part), failures_, policy_.attempts - 1)
             << std::endl;

    connection.interruption().sleep(pause_);
    pause_ = std::min(2 * pause_, policy_.longest_pause);
    return true;
  }

private:
  const RetryPolicy policy_{};
  int failures_ = 0;
  std::chrono::milliseconds pause_ = policy_.first_pause;
};

Download download(Connection& connection, const Source& source, const fs::path& file,
                  std::ostream& messages) {
  constexpr int most_beginnings = 6;
  PartialFile part(file, messages);
  CutStreams cuts;
  std::string sha256;

  for (int beginnings = 1; beginnings <= most_beginnings;) {
    const Attempt attempt = append_rest(connection, source, sha256, part.path());
    if (attempt.total >= 0) sha256 = attempt.sha256;
    if (!attempt.status.ok() && connection.interruption().came()) throw interrupted_at(part.path());

    if (attempt.received) cuts.received();
    if (cut(attempt, part.path()) && cuts.may_go_on(connection, part.path(), messages)) continue;

    // Another file has taken the place of the one that was begun: begin again. A checksum that does
    // not match has the same remedy.
    if (!of_another(attempt)) {
      if (!attempt.status.ok() && size_of(part.path()) == 0) fs::remove(part.path());
      check(attempt.status, connection.server());
      if (const auto whole = part.finish(attempt)) return *whole;
    }

    part.begin_again();
    sha256.clear();
    ++beginnings;
  }

  throw CommandFailed(ExitCode::unreachable,
                      fmt::format("could not fetch {} with the right checksum from {}", source.name,
                                  connection.server()));
}

}  // namespace

Download download(Connection& connection, const std::string& id, const std::string& artifact,
                  const fs::path& file, std::ostream& messages) {
  v1::FetchResultRequest request;
  request.set_id(id);
  request.set_artifact(artifact);
  const auto open = [&](grpc::ClientContext& context, std::int64_t offset, const std::string&) {
    request.set_offset(offset);
    return connection.stub().FetchResult(&context, request);
  };
  return download(connection, {artifact, open}, file, messages);
}

Download download_study(Connection& connection, const std::string& id, const fs::path& file,
                        std::ostream& messages) {
  v1::FetchStudyRequest request;
  request.set_id(id);
  const auto open = [&](grpc::ClientContext& context, std::int64_t offset,
                        const std::string& sha256) {
    request.set_offset(offset);
    request.set_sha256(sha256);
    return connection.stub().FetchStudy(&context, request);
  };
  return download(connection, {"study " + id, open}, file, messages);
}

std::string read_file_of_job(Connection& connection, const std::string& id,
                             const std::string& name) {
  v1::FetchResultRequest request;
  request.set_id(id);
  request.set_artifact(name);
  grpc::ClientContext context;
  const Interruption::Call call(connection.interruption(), context);
  const auto reader = connection.stub().FetchResult(&context, request);
  std::string text;
  v1::FetchResultResponse chunk;
  while (reader->Read(&chunk)) text += chunk.data();
  const grpc::Status status = reader->Finish();
  // Ctrl-C cancels the call, whose status then blames the server.
  if (!status.ok() && connection.interruption().came()) throw Interrupted("nothing was fetched");
  check(status, connection.server());
  return text;
}

}  // namespace dccast::client
