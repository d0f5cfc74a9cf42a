#include "client/session/uploads.hpp"

#include <fstream>
#include <memory>
#include <utility>

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

  v1::Attachment named;
  named.set_name(file.name);
  named.set_sha256(file.sha256);
  named.set_size_bytes(file.bytes);
  v1::UploadAttachmentResponse response;
  return upload_parts(
      connection, named,
      [&] {
        std::string part(chunk_bytes, '\0');
        stream.read(part.data(), static_cast<std::streamsize>(part.size()));
        part.resize(static_cast<std::size_t>(stream.gcount()));
        return part;
      },
      response);
}

}  // namespace

grpc::Status upload_parts(Connection& connection, const v1::Attachment& named,
                          const std::function<std::string()>& next_part,
                          v1::UploadAttachmentResponse& response) {
  grpc::ClientContext context;
  const Interruption::Call call(connection.interruption(), context);
  const auto writer = connection.stub().UploadAttachment(&context, &response);

  Request request;
  *request.mutable_attachment() = named;
  bool wanted = writer->Write(request);
  // The server ends the stream at once where it has a file of this checksum.
  if (wanted) wait_for_server(*writer);

  try {
    while (wanted) {
      std::string part = next_part();
      if (part.empty()) break;
      request.set_chunk(std::move(part));
      wanted = writer->Write(request);
    }
  } catch (...) {
    context.TryCancel();
    writer->Finish();
    throw;
  }
  writer->WritesDone();
  return writer->Finish();
}

void upload_files(Connection& connection, const std::vector<case_file::AttachedFile>& files) {
  const auto upload_all = [files](Connection& to) {
    for (const case_file::AttachedFile& file : files)
      check(to.with_retries([&] { return upload(to, file); }), to.server());
  };
  upload_all(connection);
  if (!files.empty()) connection.set_restore(upload_all);
}

}  // namespace dccast::client
