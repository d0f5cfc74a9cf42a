#include "client/text/data_study_text.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include <fmt/core.h>

#include "client/session/data_study.hpp"
#include "client/text/job_text.hpp"
#include "client/text/table.hpp"
#include "client/text/terminal.hpp"

namespace dccast::client::render {
namespace {

constexpr int most_instants = 8;
constexpr int most_shares = 12;
constexpr double small_share = 0.01;  // of the variance

std::string percent(double share, double error) {
  return fixed(100.0 * share, 0) + " ± " + fixed(std::max(1.0, 200.0 * error), 0) + " %";
}

double last(const google::protobuf::RepeatedField<double>& values) {
  return values.empty() ? 0.0 : values[values.size() - 1];
}

/// Axes by their total share at the end, largest first; the last share is that of no axis.
std::vector<int> by_share(const v1::Spread& spread) {
  std::vector<int> axes(static_cast<std::size_t>(std::max(0, spread.shares_size() - 1)));
  std::iota(axes.begin(), axes.end(), 0);
  std::ranges::stable_sort(axes, std::ranges::greater(),
                           [&](int axis) { return last(spread.shares(axis).total()); });
  return axes;
}

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

std::string history_table(const v1::Spread& spread) {
  Table table({">t s", ">cast mm", ">5 %", ">50 %", ">95 % mm", ">surface off by mm"});
  const auto& time_s = spread.time_s();  // of the hold nothing is to be seen
  const int first = static_cast<int>(std::ranges::upper_bound(time_s, 0.0) - time_s.begin());
  const int count = time_s.size() - first;
  const int rows = std::min(count, most_instants);
  for (int row = 1; row <= rows; ++row) {
    const int i = first + row * count / rows - 1;
    table.add({fixed(spread.time_s(i), 0), mm(spread.cast_length_m(i), 0), mm(spread.low_m(i)),
               mm(spread.median_m(i)), mm(spread.high_m(i)), mm(spread.surface_error_m(i))});
  }
  return table.text();
}

/// "====|    " of an effect: to the left what lowers the curl, to the right what raises it.
std::string bar_of(const Effect& effect, double most_m) {
  constexpr int half = 7;
  const double low = effect.low_m.value_or(0.0), high = effect.high_m.value_or(0.0);
  const auto length = [&](double amount) {
    return static_cast<std::size_t>(std::lround(half * std::min(1.0, amount / most_m)));
  };
  const std::size_t left = length(std::max(0.0, -std::min(low, high)));
  const std::size_t right = length(std::max(0.0, std::max(low, high)));
  return std::string(half - left, ' ') + std::string(left, '=') + "|" + std::string(right, '=') +
         std::string(half - right, ' ');
}

std::string signed_mm(const std::optional<double>& metres, const std::string& failure) {
  if (!metres) return failure.empty() ? "-" : "fails";
  const std::string text = mm(*metres);
  return *metres > 0.0 ? "+" + text : text;
}

std::string name_of(const v1::SweepPlan::Axis& axis) {
  return axis.key().ends_with(".shift") ? axis.key() : datum_of(axis.key());
}

/// Below it a curl does not answer: a fiftieth of a millimetre, a tenth of the error of a
/// difference.
double not_felt_m(const Effects& effects) {
  return std::max(2e-5, 0.1 * effects.error_m.value_or(0.0));
}

}  // namespace

std::string head_of(const v1::StudyResult& result) {
  const std::string lost = losses(result);
  return fmt::format("study {}: {}\n{} runs: {}{}\n", result.study().id(), result.study().title(),
                     result.runs_size(), count_runs(result).text(),
                     lost.empty() ? "" : " (" + lost + ")");
}

Rows share_rows(const v1::StudyResult& result) {
  const v1::Spread& spread = result.spread();
  Rows rows;
  for (const int axis : by_share(spread)) {
    const v1::Spread::Share& share = spread.shares(axis);
    if (rows.size() >= most_shares || last(share.total()) < small_share) break;
    const auto& asked = result.study().sweep().axes(axis);
    rows.push_back({datum_of(asked.key()), range_of(asked),
                    percent(last(share.first()), last(share.first_error())),
                    percent(last(share.total()), last(share.total_error()))});
  }
  if (spread.shares().empty()) return rows;
  const std::string rest = fixed(100.0 * last(spread.shares(spread.shares_size() - 1).total()), 0);
  rows.push_back({"what the response surface does not follow", "", rest + " %    ", ""});
  return rows;
}

std::optional<double> mesh_error_at_end_m(const v1::Spread& spread,
                                          std::optional<double> mesh_error) {
  if (!mesh_error || spread.median_m().empty()) return std::nullopt;
  return *mesh_error * std::abs(last(spread.median_m()));
}

std::vector<std::string> uncertainty_sentences(const v1::StudyResult& result,
                                               std::optional<double> mesh_error) {
  const v1::Spread& spread = result.spread();
  const std::optional<double> mesh_error_m = mesh_error_at_end_m(spread, mesh_error);
  if (spread.time_s().empty()) return {"No answer yet: " + result.spread_fault()};
  const double width = last(spread.high_m()) - last(spread.low_m());
  std::vector<std::string> sentences;
  sentences.push_back(fmt::format(
      "At {} s 9 of 10 castings have {} to {} mm at the {}, half of them less than {} mm.",
      fixed(last(spread.time_s()), 0), mm(last(spread.low_m())), mm(last(spread.high_m())),
      spread.monitor(), mm(last(spread.median_m()))));
  sentences.push_back(mesh_error_m
                          ? "Mesh and time steps add ± " + mm(*mesh_error_m) + " mm."
                          : "What mesh and time steps add is not known for such a case: run "
                            "dccast convergence.");
  if (spread.has_inside_band())
    sentences.push_back(fixed(100.0 * spread.inside_band(), 0) +
                        " % of castings end inside the accepted band.");
  sentences.push_back(
      fmt::format("The response surface of {} runs is off by {} mm; that is in the figures.",
                  spread.runs(), mm(last(spread.surface_error_m()))));
  const auto axes = by_share(spread);
  if (axes.empty() || !(last(spread.shares(axes.front()).total()) > small_share)) return sentences;
  const v1::Spread::Share& first = spread.shares(axes.front());
  const double rest = std::sqrt(std::max(0.0, 1.0 - last(first.first())));
  sentences.push_back(fmt::format(
      "Measure {} first: were it known exactly, the {} mm between 5 and 95 % would be {} mm.",
      datum_of(result.study().sweep().axes(axes.front()).key()), mm(width), mm(rest * width)));
  return sentences;
}

std::string uncertainty_text(const v1::StudyResult& result, std::optional<double> mesh_error) {
  std::string text = head_of(result);
  if (!result.spread().time_s().empty()) {
    text += "\ncurl of the " + result.spread().monitor() + "\n" + history_table(result.spread());
    const Rows rows = share_rows(result);
    text += "\nwhat the variance at the end comes from\n" +
            Table({"datum", "range", ">alone", ">with others"}, rows).text();
    const int rest = result.spread().shares_size() - static_cast<int>(rows.size());
    if (rest > 0) text += std::to_string(rest) + " more data, with less than these\n";
  }
  return text + "\n" + paragraphs(uncertainty_sentences(result, mesh_error));
}

EffectRows effect_rows(const v1::StudyResult& result, const Effects& effects) {
  EffectRows found;
  const double most = effects.effects.empty() ? 0.0 : effects.effects.front().largest_m();
  for (const Effect& effect : effects.effects) {
    const auto& axis = result.study().sweep().axes(effect.axis);
    const bool complete = effect.low_m && effect.high_m;
    if (complete && effect.largest_m() < not_felt_m(effects)) {
      found.rest += (found.rest.empty() ? "" : ", ") + name_of(axis);
      continue;
    }
    auto& rows = is_lever(axis.key()) ? found.levers : found.data;
    rows.push_back({name_of(axis), range_of(axis), signed_mm(effect.low_m, effect.low_failure),
                    signed_mm(effect.high_m, effect.high_failure),
                    most > 0.0 ? bar_of(effect, most) : ""});
  }
  return found;
}

std::string sensitivity_text(const v1::StudyResult& result, int monitor,
                             std::optional<double> of_curl) {
  std::string text = head_of(result);
  const Effects effects = effects_of(result, monitor, of_curl);
  if (!effects.base_m) return text + "the case itself has no valid run: nothing to compare with\n";
  text += "\ncurl of the " + result.monitors(monitor) + " at the end: " + mm(*effects.base_m) +
          " mm; change at the two ends of each range\n";
  const EffectRows rows = effect_rows(result, effects);
  for (const auto& [title, part] :
       {std::pair("lever of the plant", &rows.levers), {"datum", &rows.data}})
    if (!part->empty())
      text += Table({title, "range", ">low mm", ">high mm", "   less|more"}, *part).text() + "\n";
  text += effects.error_m ? "A small difference is known to ± " + mm(*effects.error_m) +
                                " mm: mesh and time steps.\n"
                          : "The error of a difference has not been measured for such a case.\n";
  if (!rows.rest.empty()) text += paragraphs({"This model does not respond to " + rows.rest + "."});
  for (const Effect& effect : effects.effects)
    for (const auto& [failure, end] :
         {std::pair(effect.low_failure, 0), std::pair(effect.high_failure, 1)})
      if (!failure.empty())
        text += result.study().sweep().axes(effect.axis).key() + " = " +
                result.study().sweep().axes(effect.axis).values(end) + ": " + failure + "\n";
  return text;
}

}  // namespace dccast::client::render
