#include "client/session/uploads.hpp"

#include <array>
#include <fstream>
#include <memory>

namespace dccast::client {
namespace {

using Request = v1::UploadAttachmentRequest;

constexpr std::size_t chunk_bytes = 256'000;  // service.proto

/// Waits until the server accepts the content, or has answered.
void wait_for_server(grpc::ClientWriterInterface<Request>& writer) {
  // gRPC's stub interface lacks this call; without it, content would be sent that the server
  // already has.
  if (auto* stream = dynamic_cast<grpc::ClientWriter<Request>*>(&writer))
    stream->WaitForInitialMetadata();
}

/// One attempt to upload a file. @return its status
grpc::Status upload(Connection& connection, const case_file::AttachedFile& file) {
  std::ifstream stream(file.path, std::ios::binary);
  if (!stream) throw invalid("cannot read " + file.path.string());

  grpc::ClientContext context;
  const Interruption::Call call(connection.interruption(), context);
  v1::UploadAttachmentResponse response;
  const auto writer = connection.stub().UploadAttachment(&context, &response);

  Request request;
  request.mutable_attachment()->set_name(file.name);
  request.mutable_attachment()->set_sha256(file.sha256);
  request.mutable_attachment()->set_size_bytes(file.bytes);
  bool wanted = writer->Write(request);
  // The server ends the stream at once where it has a file of this checksum.
  if (wanted) wait_for_server(*writer);

  std::array<char, chunk_bytes> chunk;
  while (wanted && stream.read(chunk.data(), chunk.size()).gcount() > 0) {
    request.set_chunk(chunk.data(), static_cast<std::size_t>(stream.gcount()));
    wanted = writer->Write(request);
  }
  writer->WritesDone();
  return writer->Finish();
}

}  // namespace

void upload_files(Connection& connection, const std::vector<case_file::AttachedFile>& files) {
  const auto upload_all = [files](Connection& to) {
    for (const case_file::AttachedFile& file : files)
      check(to.with_retries([&] { return upload(to, file); }), to.server());
  };
  upload_all(connection);
  if (!files.empty()) connection.set_restore(upload_all);
}

}  // namespace dccast::client
