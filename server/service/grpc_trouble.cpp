#include "server/service/grpc_trouble.hpp"

#include <google/protobuf/descriptor.h>
#include <grpc/support/log.h>

#include <string>

#include "dccast/v1/service.grpc.pb.h"
#include "server/jobs/log.hpp"

namespace dccast::service {

namespace {

using grpc::experimental::InterceptionHookPoints;

/// @param method  "/dccast.v1.SimulationService/GetJob"
bool is_a_call_of_ours(const std::string& method) {
  const std::string service = v1::SimulationService::service_full_name();
  const auto* declared =
      google::protobuf::DescriptorPool::generated_pool()->FindServiceByName(service);
  return declared != nullptr && method.starts_with("/" + service + "/") &&
         declared->FindMethodByName(method.substr(service.size() + 2)) != nullptr;
}

grpc::Status in_words(const std::string& method) {
  if (is_a_call_of_ours(method))
    return {
        grpc::StatusCode::INVALID_ARGUMENT,
        "the request of " + method +
            " cannot be read as the message that service.proto names; use a client made from it"};
  return {grpc::StatusCode::UNIMPLEMENTED, "dccastd has no call " + method};
}

/// Lives as long as its call.
class Answer final : public grpc::experimental::Interceptor {
public:
  explicit Answer(std::string method) : method_(std::move(method)) {}

  void Intercept(grpc::experimental::InterceptorBatchMethods* batch) override {
    if (batch->QueryInterceptionHookPoint(InterceptionHookPoints::PRE_SEND_STATUS)) {
      const grpc::Status status = batch->GetSendStatus();
      // No handler of ours answers so: each that refuses gives its reason.
      if (status.error_code() == grpc::StatusCode::UNIMPLEMENTED && status.error_message().empty())
        batch->ModifySendStatus(in_words(method_));
    }
    batch->Proceed();
  }

private:
  const std::string method_;
};

}  // namespace

void log_grpc_as_debug() {
  gpr_set_log_function([](gpr_log_func_args* line) {
    spdlog::debug("gRPC {}:{}: {}", line->file, line->line, line->message);
  });
}

grpc::experimental::Interceptor* UnreadableRequests::CreateServerInterceptor(
    grpc::experimental::ServerRpcInfo* call) {
  return new Answer(call->method());
}

}  // namespace dccast::service
