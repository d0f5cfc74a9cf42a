#include "server/studies/studies.hpp"

#include <utility>

namespace dccast::studies {

Studies::Studies(StudyOptions options, StudyStore& store, jobs::Scheduler& scheduler,
                 const intake::CaseIntake& intake)
    : state_(std::move(options), store, scheduler, intake),
      results_(state_),
      surfaces_(state_, results_),
      feeder_(state_, results_),
      requests_(state_, feeder_, results_, surfaces_),
      evaluation_(state_, results_, surfaces_) {
  // When a job of a study changes its state, the next run may be queued, or dropped.
  scheduler.observe([this](const v1::Job& job) {
    if (job.study().empty()) return;
    state_.note_change(job.study());
    feeder_.wake();
  });
}

Studies::~Studies() {
  stop();
}

void Studies::start() {
  feeder_.start();
  surfaces_.start();
}

void Studies::stop() {
  state_.scheduler.observe({});
  surfaces_.stop();
  feeder_.stop();
}

}  // namespace dccast::studies
