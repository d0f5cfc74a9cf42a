#include <google/protobuf/stubs/common.h>
#include <grpcpp/grpcpp.h>

#include "server/jobs/quarantine.hpp"
#include "server/service/handlers.hpp"

namespace dccast::service {

grpc::Status get_server_info(Context& context, const Call&, const v1::GetServerInfoRequest&,
                             v1::GetServerInfoResponse& response) {
  response.set_version(context.version);
  response.set_workers(context.workers);
  response.set_queued(context.scheduler.queued());
  response.set_running(context.scheduler.running());
  response.set_maximum_message_bytes(context.maximum_message_bytes);
  response.set_maximum_queued(context.maximum_queued);
  response.set_storage_fault(context.scheduler.held());
  response.set_quarantined(
      static_cast<int>(jobs::quarantined_folders(context.jobs_directory).size()));
  response.set_paused(context.store.count(v1::PAUSED));
  response.set_maximum_nodes(context.intake.ceilings().nodes);
  response.set_maximum_steps(context.intake.ceilings().steps);
  response.set_maximum_memory_bytes(context.intake.ceilings().memory_bytes);
  response.set_build(std::string("g++ ") + __VERSION__ + ", gRPC " + grpc::Version() +
                     ", protobuf " +
                     google::protobuf::internal::VersionString(GOOGLE_PROTOBUF_VERSION));
  return grpc::Status::OK;
}

}  // namespace dccast::service
