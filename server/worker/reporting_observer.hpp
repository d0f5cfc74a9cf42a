#pragma once

#include <vector>

#include "core/case/case.hpp"
#include "core/casting/step_observer.hpp"
#include "server/worker/run_link.hpp"

namespace dccast::worker {

/// Makes events of what the run reports, and brings it requests to stop.
class ReportingObserver : public casting::StepObserver {
public:
  ReportingObserver(RunLink& link, const casting::Case& of_run) : link_(link), case_(of_run) {}
  casting::Order on_step(const results::StepReport& report) override;
  std::vector<results::StepReport> reported_steps(std::int64_t step) override;
  void sync_reports() override { link_.sync(); }
  void on_resumed(std::int64_t step, double time) override;
  void on_validity_lost(const results::ValidityLoss& loss) override;
  void on_finding(const results::Finding& finding) override;
  void on_message(std::string_view text) override;

private:
  RunLink& link_;
  const casting::Case& case_;
};

}  // namespace dccast::worker
