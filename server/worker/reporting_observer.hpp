#pragma once

#include <vector>

#include "core/case/case.hpp"
#include "core/casting/casting_run.hpp"
#include "server/worker/run_link.hpp"

namespace dccast::worker {

/// Makes events of what the run reports, and brings it requests to stop.
class ReportingObserver : public casting::StepObserver {
public:
  ReportingObserver(RunLink& link, const std::vector<casting::Monitor>& monitors)
      : link_(link), monitors_(monitors) {}
  casting::Order on_step(const results::StepReport& report) override;
  void on_missed_step(const results::StepReport& report) override;
  void on_resumed(std::int64_t step, double time) override;
  void on_validity_lost(const results::ValidityLoss& loss) override;
  void on_finding(const results::Finding& finding) override;
  void on_message(std::string_view text) override;

private:
  void send(const results::StepReport& report);

  RunLink& link_;
  const std::vector<casting::Monitor>& monitors_;
};

}  // namespace dccast::worker
