#include "client/model/answer.hpp"

#include <algorithm>

#include "proto/case_file/override.hpp"
#include "proto/values/interpolation.hpp"

namespace dccast::client {

figures::RunHistory run_history(const v1::Job& job, const v1::QueryResultResponse& result) {
  return figures::run_history(job, {result.steps().begin(), result.steps().end()});
}

std::optional<CurlLimit> limit_at(const std::vector<double>& instants_s,
                                  const v1::StudyResult& study, const std::string& monitor) {
  const auto found = std::ranges::find(
      study.limits(), monitor,
      [](const v1::StudyResult::Limit& limit) { return limit.curve().monitor(); });
  if (found == study.limits().end()) return std::nullopt;

  const v1::CurlCurve& curve = found->curve();
  const auto at = [&](const google::protobuf::RepeatedField<double>& figures) {
    return values::at_instants(instants_s, {curve.time_s().begin(), curve.time_s().end()},
                               {figures.begin(), figures.end()});
  };
  return CurlLimit{at(curve.curl_m()), at(curve.uncertainty_m()), found->has_order()};
}

std::vector<v1::CaseChange> changes_of(const std::vector<std::string>& texts) {
  std::vector<v1::CaseChange> changes;
  for (const std::string& text : texts)
    if (auto change = case_file::parse_change(text)) changes.push_back(std::move(*change));
  return changes;
}

}  // namespace dccast::client
