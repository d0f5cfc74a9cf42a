// How much of a curl is discretisation: the case on finer and finer meshes (docs/error-bars.md).
#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "server/judging/study_parts.hpp"

namespace dccast::judging {
namespace {

constexpr double shown_m = 1e-6;  ///< levels differ by less than any plant measures

/// Index of the instant with the largest uncertainty; 0 where none is known.
int least_certain(const v1::CurlCurve& curve) {
  int worst = 0;
  for (int i = 1; i < curve.uncertainty_m_size(); ++i) {
    const double uncertainty_m = curve.uncertainty_m(i);
    // Written so that it also replaces a NaN at the beginning.
    if (std::isfinite(uncertainty_m) && !(uncertainty_m <= curve.uncertainty_m(worst))) worst = i;
  }
  return worst;
}

void add_refinement_sentences(const v1::StudyResult& result, v1::Judgement& judgement) {
  if (result.limits().empty())
    judgement.add_sentences("No limit yet: two levels that succeeded are needed.");

  for (const v1::StudyResult::Limit& limit : result.limits()) {
    const v1::CurlCurve& curve = limit.curve();
    const int last = curve.curl_m_size() - 1;
    if (last < 0) continue;
    const std::string end = fmt::format("{} ± {} mm", figures::mm(curve.curl_m(last), 3),
                                        figures::mm(curve.uncertainty_m(last), 3));
    judgement.add_sentences(
        limit.has_order()
            ? fmt::format("The curl of the {} at the end tends to {}, with order {:.2f}.",
                          curve.monitor(), end, limit.order())
            : fmt::format("The curl of the {} at the end is {} by the finest level: it does not "
                          "converge with an order.",
                          curve.monitor(), end));
  }

  for (const v1::StudyRun& run : result.runs()) {
    if (run.state() != v1::FAILED && run.state() != v1::CANCELLED) continue;
    std::string outcome = outcome_code(run);
    std::ranges::replace(outcome, '_', ' ');
    const std::string& why = run.failure().message();
    judgement.add_sentences(fmt::format("Refinement {} is left out: {}{}{}.", run.refinement(),
                                        outcome, why.empty() ? "" : ": ", why));
  }
}

void add_limit_chart(const v1::StudyResult& result, const v1::StudyResult::Limit& limit,
                     v1::Judgement& judgement) {
  const v1::CurlCurve& curve = limit.curve();
  v1::Chart& chart =
      add_chart(judgement, "limit", fmt::format("limit of the curl of {}", curve.monitor()),
                {"time", "s", "curl", "m"});
  if (result.has_valid_until_s()) chart.set_beyond_x(result.valid_until_s());

  v1::Chart::Line& line = *chart.add_lines();
  line.set_name("limit");
  *line.mutable_x() = curve.time_s();
  *line.mutable_y() = curve.curl_m();
  for (int i = 0; i < curve.curl_m_size(); ++i) {
    line.add_low(curve.curl_m(i) - curve.uncertainty_m(i));
    line.add_high(curve.curl_m(i) + curve.uncertainty_m(i));
  }
}

/// What the curls tend to at the end, and where they are least certain.
void add_limits(const v1::StudyResult& result, v1::Judgement& judgement) {
  v1::Table& table = add_table(judgement, "limits", "limits of the curls at the end");
  add_columns(table, {
                         text_column("monitor", "monitor"),
                         number_column("order", "order", "", 0.01),
                         number_column("limit", "limit", "m", shown_m),
                     });
  table.mutable_columns(2)->set_has_error(true);
  add_columns(table, {number_column("largest_error", "largest error", "m", shown_m),
                      number_column("at", "at", "s", 0.01)});
  if (result.has_valid_until_s())
    table.set_note(fmt::format(
        "beyond validity: from {:.2f} s on the model of at least one level is not valid",
        result.valid_until_s()));

  for (const v1::StudyResult::Limit& limit : result.limits()) {
    const v1::CurlCurve& curve = limit.curve();
    const int last = curve.curl_m_size() - 1;
    if (last < 0) continue;
    const int worst = least_certain(curve);
    add_row(table, {text_cell(curve.monitor()),
                    limit.has_order() ? number_cell(limit.order()) : code_cell("none"),
                    number_cell(curve.curl_m(last), curve.uncertainty_m(last)),
                    number_cell(curve.uncertainty_m(worst)), number_cell(curve.time_s(worst))});
  }
}

}  // namespace

void judge_refinement(const v1::StudyResult& result, v1::Judgement& judgement) {
  add_refinement_sentences(result, judgement);
  add_runs(result, judgement);
  if (result.limits().empty()) return;

  add_limits(result, judgement);
  for (const v1::StudyResult::Limit& limit : result.limits())
    add_limit_chart(result, limit, judgement);
}

}  // namespace dccast::judging
