#pragma once

#include "dccast/v1/worker.grpc.pb.h"
#include "server/jobs/scheduler.hpp"
#include "server/service/work_pool.hpp"

namespace dccast::service {

/// The daemon's end of the worker link: one call per worker, as long as its job runs.
class WorkerLink final : public v1::WorkerLink::CallbackService {
public:
  explicit WorkerLink(jobs::Scheduler& scheduler) : scheduler_(scheduler) {}
  grpc::ServerBidiReactor<v1::WorkerMessage, v1::WorkerOrder>* Run(
      grpc::CallbackServerContext* call) override;

private:
  jobs::Scheduler& scheduler_;
  WorkPool in_order_{1};  ///< for what waits for the disk; first "finished", then "the link ended"
};

}  // namespace dccast::service
