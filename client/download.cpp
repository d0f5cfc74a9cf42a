#include "client/download.hpp"

#include <chrono>
#include <fstream>
#include <ostream>

#include "proto/values/sha256.hpp"

namespace dccast::client {
namespace {

namespace fs = std::filesystem;

std::int64_t size_of(const fs::path& file) {
  std::error_code error;
  const auto size = fs::file_size(file, error);
  return error ? 0 : static_cast<std::int64_t>(size);
}

struct Attempt {
  grpc::Status status;
  std::int64_t total = -1;
  std::string sha256;
};

/// Appends to the part file what the server has beyond it.
Attempt append_rest(Connection& connection, const std::string& id, const std::string& artifact,
                    const fs::path& part) {
  v1::FetchResultRequest request;
  request.set_id(id);
  request.set_artifact(artifact);
  request.set_offset(size_of(part));
  std::ofstream stream(part, std::ios::binary | std::ios::app);
  if (!stream) throw CommandFailed(ExitCode::not_found, "cannot write " + part.string());
  grpc::ClientContext context;
  const Interruption::Call call(connection.interruption(), context);
  const auto reader = connection.stub().FetchResult(&context, request);
  Attempt attempt;
  v1::FetchResultResponse chunk;
  while (reader->Read(&chunk)) {
    stream.write(chunk.data().data(), static_cast<std::streamsize>(chunk.data().size()));
    if (!stream) {
      context.TryCancel();
      throw CommandFailed(ExitCode::not_found,
                          "cannot write " + part.string() + "; is the disk full?");
    }
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

}  // namespace

Download download(Connection& connection, const std::string& id, const std::string& artifact,
                  const fs::path& file, std::ostream& talk) {
  const fs::path part = file.string() + ".part";
  constexpr int attempts = 6;
  Download result;
  result.resumed_at = size_of(part);
  if (result.resumed_at > 0)
    talk << "fetch: going on after the " << result.resumed_at << " bytes in " << part.string()
         << std::endl;
  for (int count = 1; count <= attempts; ++count) {
    const Attempt attempt = append_rest(connection, id, artifact, part);
    if (!attempt.status.ok() && connection.interruption().came()) throw interrupted_at(part);
    if (cut(attempt, part) && count < attempts) {
      talk << "fetch: the stream was cut at byte " << size_of(part) << ", going on" << std::endl;
      connection.interruption().sleep(std::chrono::milliseconds(200 * count));
      continue;
    }
    const bool beyond = attempt.status.error_code() == grpc::StatusCode::OUT_OF_RANGE;
    if (!beyond) {
      if (!attempt.status.ok() && size_of(part) == 0) fs::remove(part);
      check(attempt.status, connection.server());
      if (attempt.total == size_of(part) && values::sha256_of_file(part) == attempt.sha256) {
        fs::rename(part, file);
        result.bytes = attempt.total;
        result.sha256 = attempt.sha256;
        return result;
      }
    }
    talk << "fetch: " << part.string() << " is not the beginning of this file; beginning again"
         << std::endl;
    fs::remove(part);
    result.resumed_at = 0;
  }
  throw CommandFailed(
      ExitCode::unreachable,
      "could not fetch " + artifact + " with the right checksum from " + connection.server());
}

}  // namespace dccast::client
