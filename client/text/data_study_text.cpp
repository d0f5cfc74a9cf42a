#include "client/text/data_study_text.hpp"

#include <map>

#include <fmt/core.h>

#include "client/text/job_text.hpp"
#include "client/text/table.hpp"

namespace dccast::client::render {
namespace {

/// "2 OUT_OF..., 1 solve failed": why runs are not among those that count.
std::string losses(const v1::StudyResult& result) {
  std::map<std::string, int> kinds;
  for (const v1::StudyRun& run : result.runs())
    if (run.has_failure())
      ++kinds[run.failure().finding().empty() ? failure_kind_text(run.failure().kind())
                                              : run.failure().finding()];
  return joined(kinds, ", ",
                [](const auto& kind) { return std::to_string(kind.second) + " " + kind.first; });
}

}  // namespace

std::string head_of(const v1::StudyResult& result) {
  const std::string lost = losses(result);
  return fmt::format("study {}: {}\n{} runs: {}{}\n", result.study().id(), result.study().title(),
                     result.runs_size(), count_runs(result).text(),
                     lost.empty() ? "" : " (" + lost + ")");
}

}  // namespace dccast::client::render
