#pragma once

#include <grpcpp/support/server_callback.h>

#include <cstdint>
#include <functional>
#include <string>

#include "dccast/v1/service.pb.h"
#include "core/storage/file.hpp"
#include "server/service/stream_call.hpp"
#include "server/service/work_pool.hpp"

namespace dccast::service {

/// A file on its way to a client.
struct SentFile {
  storage::File file;
  std::string name;  ///< for messages
  std::int64_t size = 0;
  std::string sha256;
};

/// Opens the file of a call. What it throws is handled by guarded().
using OpenFile = std::function<grpc::Status(const Call&, SentFile&)>;

/// Sends a file in chunks from `offset` on; OUT_OF_RANGE where that lies beyond its end. The file
/// is opened in `lane`. The reactor deletes itself when its call is done.
grpc::ServerWriteReactor<v1::FetchResultResponse>* send_file(WorkPool& lane, const StreamCall& call,
                                                             std::int64_t offset, OpenFile open);

}  // namespace dccast::service
