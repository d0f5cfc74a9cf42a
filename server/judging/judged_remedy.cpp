#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "proto/figures/rounding.hpp"
#include "proto/figures/run_history.hpp"
#include "server/judging/study_parts.hpp"

namespace dccast::judging {
namespace {

/// A figure of the history that shows how far a casting is from a finding.
struct FindingFigure {
  const char* code;
  const char* unit;  ///< of the finding
  const char* name;
  double (*of)(const v1::StepReport&);
  bool less_is_worse;
};

double judged_lift_m(const v1::StepReport& step) {
  const v1::MonitorValue* const judged = figures::judged_curl(step);
  return judged == nullptr ? 0.0 : std::max(judged->curl_m(), 0.0);
}

const std::array all_figures{
    FindingFigure{"thin_shell", "m", "least shell", [](const auto& s) { return s.least_shell_m(); },
                  true},
    FindingFigure{"remelting_in_gap", "m", "least shell",
                  [](const auto& s) { return s.least_shell_m(); }, true},
    FindingFigure{"bleed_out_at_exit", "m", "shell at the water line",
                  [](const auto& s) { return s.shell_at_water_line_m(); }, true},
    FindingFigure{"freezes_at_meniscus", "m", "depth of freezing",
                  [](const auto& s) { return s.shell_begins_m(); }, true},
    FindingFigure{"bottom_shell_fails", "m", "shell over the block",
                  [](const auto& s) { return s.bottom_shell_m(); }, true},
    FindingFigure{"bottom_shell_open", "m", "shell over the block",
                  [](const auto& s) { return s.bottom_shell_m(); }, true},
    FindingFigure{"bleed_out_at_bottom", "m", "shell over the block",
                  [](const auto& s) { return s.bottom_shell_m(); }, true},
    FindingFigure{"shell_melted_through", "m", "shell over the block",
                  [](const auto& s) { return s.bottom_shell_m(); }, true},
    FindingFigure{"sump_too_deep", "1", "sump", [](const auto& s) { return s.sump_depth_m(); },
                  false},
    FindingFigure{"slip_too_large", "m", "slip", [](const auto& s) { return s.bottom_slip_m(); },
                  false},
    FindingFigure{"rotation_too_large", "rad", "rotation",
                  [](const auto& s) { return s.maximum_rotation_rad(); }, false},
    FindingFigure{"lift_too_large", "m", "curl", judged_lift_m, false},
    FindingFigure{"curl_outside_band", "m", "curl", judged_lift_m, false},
    FindingFigure{"hot_tears", "s-1", "strain rate in the window",
                  [](const auto& s) { return s.tear_rate_per_s(); }, false},
    FindingFigure{"hot_tears", "Pa", "pressure drop in the mush",
                  [](const auto& s) { return s.tear_pressure_pa(); }, false},
};

const FindingFigure* figure_of(const v1::Finding& finding) {
  const auto found = std::ranges::find_if(all_figures, [&](const FindingFigure& figure) {
    return finding.code() == figure.code && finding.unit() == figure.unit;
  });
  return found == all_figures.end() ? nullptr : &*found;
}

/// The unit of a figure in SI; a sump is judged as a share and read as a depth.
const char* unit_of(const FindingFigure& figure) {
  return std::string(figure.code) == "sump_too_deep" ? "m" : figure.unit;
}

/// A run of the study with its history.
struct Draft {
  const v1::StudyRun& run;
  const JudgedRun& history;
};

const v1::Finding* finding_of(const v1::StudyRun& run, const std::string& code) {
  const auto found = std::ranges::find(run.findings(), code, &v1::Finding::code);
  return found == run.findings().end() ? nullptr : &*found;
}

/// The worst of two values of a figure.
double worse(const FindingFigure& figure, double a, double b) {
  return figure.less_is_worse ? std::min(a, b) : std::max(a, b);
}

/// The worst value of a figure from a cast length on, and of the run's finding itself: the step
/// that ends a run is not reported. Empty: the run did not get there.
std::optional<double> worst_from(const FindingFigure& figure, const Draft& draft,
                                 double cast_length_m) {
  std::optional<double> worst;
  const auto add = [&](double value) { worst = worse(figure, value, worst.value_or(value)); };

  for (const v1::StepReport& step : draft.history.steps)
    if (step.time_s() > 0.0 && step.cast_length_m() >= cast_length_m) add(figure.of(step));

  const v1::Finding* const finding = finding_of(draft.run, figure.code);
  if (finding == nullptr || finding->unit() != unit_of(figure)) return worst;
  if (finding->has_value()) add(finding->value());
  if (finding->has_worst()) add(finding->worst().value());
  return worst;
}

/// Cast length at which a finding was raised; 0 for one of the case alone.
double length_of(const v1::Finding& finding, const JudgedRun& run) {
  if (!finding.has_time_s() || run.steps.empty()) return 0.0;
  const auto step = std::ranges::find_if(
      run.steps, [&](const v1::StepReport& other) { return other.time_s() >= finding.time_s(); });
  return step == run.steps.end() ? run.steps.back().cast_length_m() : step->cast_length_m();
}

/// What one draft does to one finding.
struct Effect {
  const Draft* draft = nullptr;
  std::optional<double> value{};             ///< of the finding's figure [its unit]
  Verdict verdict = Verdict::no_difference;  ///< of the difference to the case itself
  bool is_gone = false;                      ///< the run ends and does not raise the finding
  bool is_better = false;                    ///< nearer to no finding, by more than the error
  std::optional<CurlDifference> curl{};      ///< real ones of the judged monitor
  std::vector<std::string> dangers{};        ///< that the case itself does not have
  std::vector<std::string> warnings{};       ///< the same

  bool helps() const { return dangers.empty() && (is_better || (!value && is_gone)); }
  int steps() const { return draft->run.lever_step().steps(); }
  const std::string& lever() const { return draft->run.lever_step().key(); }
};

/// A finding with what the drafts do to it.
struct Answer {
  const v1::Finding& finding;             ///< of the job
  const FindingFigure* figure = nullptr;  ///< null: none in the history
  std::optional<double> before{};         ///< in the draft of the case [unit of the figure]
  std::optional<double> error{};          ///< of a difference of two drafts
  bool is_in_draft = false;               ///< the draft of the case raises it too
  std::vector<Effect> effects{};          ///< in the order of the runs

  /// How much nearer to no finding, in shares of the value before; a finding that has gone counts
  /// most.
  double gain(const Effect& effect) const {
    if (!effect.value || !before) return 0.0;
    const double change = *effect.value - *before;
    return (figure->less_is_worse ? change : -change) / std::max(std::abs(*before), 1e-9);
  }
};

class Remedy {
public:
  explicit Remedy(const StudyToJudge& study) : study_(study) {
    for (int i = 0; i < study.result.runs_size() && i < std::ssize(study.runs); ++i)
      drafts_.push_back({study.result.runs(i), study.runs[static_cast<std::size_t>(i)]});
    for (const Draft& draft : drafts_) {
      if (draft.run.has_lever_step()) continue;
      (base_ == nullptr ? base_ : companion_) = &draft;
    }
  }

  /// Null: it has not run, or its job was deleted.
  const Draft* base() const { return base_; }

  Answer answer(const v1::Finding& finding) const {
    Answer answer{finding, figure_of(finding)};
    const v1::Finding* const in_draft = finding_of(base_->run, finding.code());
    answer.is_in_draft = in_draft != nullptr;
    if (!answer.is_in_draft) return answer;

    const double from_m = length_of(*in_draft, base_->history);
    if (answer.figure != nullptr) {
      answer.before = worst_from(*answer.figure, *base_, from_m);
      answer.error = error_of(answer, from_m);
    }
    for (const Draft& draft : drafts_)
      if (draft.run.has_lever_step() && has_ended(draft.run))
        answer.effects.push_back(effect_of(draft, answer, from_m));
    return answer;
  }

private:
  static bool has_ended(const v1::StudyRun& run) {
    return run.state() == v1::SUCCEEDED || run.state() == v1::FAILED;
  }

  /// What the draft is off the engineering run of the same case. It bounds the error of a
  /// difference of two drafts from above, as most of it is common to both.
  std::optional<double> error_of(const Answer& answer, double from_m) const {
    if (companion_ == nullptr || !answer.before) return std::nullopt;
    const auto finer = worst_from(*answer.figure, *companion_, from_m);
    if (!finer) return std::nullopt;
    // One pair can agree by chance.
    constexpr double least_share = 0.02;
    return std::max(std::abs(*finer - *answer.before), least_share * std::abs(*answer.before));
  }

  Effect effect_of(const Draft& draft, const Answer& answer, double from_m) const {
    Effect effect{&draft};
    effect.is_gone = is_valid(draft.run) && finding_of(draft.run, answer.finding.code()) == nullptr;
    if (answer.figure != nullptr) effect.value = worst_from(*answer.figure, draft, from_m);
    if (effect.value && answer.before) {
      const double change = *effect.value - *answer.before;
      effect.verdict = !answer.error                      ? Verdict::of_unknown_error
                       : std::abs(change) > *answer.error ? Verdict::real
                                                          : Verdict::within_its_error;
      effect.is_better = effect.verdict == Verdict::real && is_valid(draft.run) &&
                         (answer.figure->less_is_worse == (change > 0.0));
    }
    add_curl(draft, effect);
    add_raised(draft.run, effect);
    return effect;
  }

  /// At equal cast length: a slower casting is not flatter because it is shorter.
  void add_curl(const Draft& draft, Effect& effect) const {
    if (study_.monitor < 0 || study_.monitor >= study_.result.monitors_size()) return;
    for (CurlDifference& difference : curl_differences({base_->history, draft.history}))
      if (difference.monitor == study_.result.monitors(study_.monitor))
        effect.curl = std::move(difference);
  }

  void add_raised(const v1::StudyRun& run, Effect& effect) const {
    for (const v1::Finding& finding : run.findings()) {
      if (finding.severity() <= v1::Finding::NOTE || finding_of(base_->run, finding.code()))
        continue;
      (finding.severity() == v1::Finding::DANGER ? effect.dangers : effect.warnings)
          .push_back(finding.code());
    }
  }

  const StudyToJudge& study_;
  std::vector<Draft> drafts_;
  const Draft* base_ = nullptr;       ///< the case as a draft
  const Draft* companion_ = nullptr;  ///< the case at engineering
};

/// A figure in the unit of a plant, with the decimals that its error leaves; two digits where none
/// is known.
std::string figure_text(double value, const std::string& unit, std::optional<double> error) {
  const v1::PlantUnit plant = plant_unit(unit);
  const double shown = plant.factor() * value;
  const double known = plant.factor() * error.value_or(0.05 * std::abs(value));
  return figures::fixed(shown, known > 0.0 ? figures::decimals_by_error(known, 1, 6) : 2);
}

/// "least shell 12 -> 19 mm; corner -4.0 ± 0.9 mm; raises hot_tears".
std::string effect_text(const Answer& answer, const Effect& effect) {
  std::string text;
  if (effect.value && answer.before) {
    const std::string unit = unit_of(*answer.figure);
    text = fmt::format("{} {} -> {} {}", answer.figure->name,
                       figure_text(*answer.before, unit, answer.error),
                       figure_text(*effect.value, unit, answer.error), plant_unit(unit).name());
  }
  if (effect.curl && effect.curl->verdict() == Verdict::real)
    text += fmt::format("{0}{1} {2:+.{4}f} ± {3:.{4}f} mm", text.empty() ? "" : "; ",
                        effect.curl->monitor, 1e3 * effect.curl->end_m,
                        1e3 * effect.curl->error_m.value_or(0.0),
                        figures::mm_decimals(effect.curl->error_m));
  if (!effect.warnings.empty())
    text += (text.empty() ? "raises " : "; raises ") + joined(effect.warnings, ", ");
  return text.empty() ? text : ": " + text;
}

/// Of each lever the smallest step after which the finding has gone, else the one that helps most;
/// levers that end the finding first, then the most effective.
std::vector<const Effect*> best_effects(const Answer& answer) {
  std::vector<const Effect*> best;
  for (const Effect& effect : answer.effects) {
    if (!effect.helps()) continue;
    const auto same = std::ranges::find_if(
        best, [&](const Effect* other) { return other->lever() == effect.lever(); });
    if (same == best.end()) {
      best.push_back(&effect);
      continue;
    }
    const bool is_preferred = effect.is_gone != (*same)->is_gone ? effect.is_gone
                              : effect.is_gone
                                  ? std::abs(effect.steps()) < std::abs((*same)->steps())
                                  : answer.gain(effect) > answer.gain(**same);
    if (is_preferred) *same = &effect;
  }

  std::ranges::stable_sort(best, [&](const Effect* a, const Effect* b) {
    return a->is_gone != b->is_gone ? a->is_gone : answer.gain(*a) > answer.gain(*b);
  });
  return best;
}

/// Changes that help in no amount, whatever general advice says: the largest one tried of each
/// lever and direction. Empty: each of them helps.
std::string without_effect(const Answer& answer) {
  std::vector<const Effect*> refuted;
  for (const Effect& effect : answer.effects) {
    const auto alike = [&](const Effect& other) {
      return other.lever() == effect.lever() && (other.steps() > 0) == (effect.steps() > 0);
    };
    const bool is_largest = std::ranges::none_of(answer.effects, [&](const Effect& other) {
      return alike(other) && std::abs(other.steps()) > std::abs(effect.steps());
    });
    const bool helps = std::ranges::any_of(answer.effects, [&](const Effect& other) {
      return alike(other) && (other.is_better || other.is_gone);
    });
    if (is_largest && !helps) refuted.push_back(&effect);
  }
  std::string text;
  for (const Effect* effect : refuted)
    text += (text.empty() ? "" : ", ") + effect->draft->run.lever_step().words();
  return text;
}

void add_sentences(const Answer& answer, v1::Judgement& judgement) {
  const std::string& code = answer.finding.code();
  if (!answer.is_in_draft) {
    judgement.add_sentences(
        fmt::format("{}: a draft of the case does not have this finding; compare runs at the "
                    "quality of the job.",
                    code));
    return;
  }

  auto best = best_effects(answer);
  constexpr std::size_t most_shown = 3;  // the table has all of them
  if (best.size() > most_shown) best.resize(most_shown);
  if (best.empty()) judgement.add_sentences(fmt::format("{}: no lever was found.", code));
  for (const Effect* effect : best)
    judgement.add_sentences(fmt::format("{} {}: {}{}.", code, effect->is_gone ? "goes" : "stays",
                                        effect->draft->run.lever_step().words(),
                                        effect_text(answer, *effect)));
  if (const std::string refuted = without_effect(answer); !best.empty() && !refuted.empty())
    judgement.add_sentences(fmt::format("{}: of no help: {}.", code, refuted));
}

std::string code_of(Verdict verdict) {
  std::string code = words(verdict);
  std::ranges::replace(code, ' ', '_');
  return code;
}

/// What the draft became of: its finding has gone, stays, or the run failed.
std::string outcome_of(const Effect& effect) {
  if (!is_valid(effect.draft->run)) return outcome_code(effect.draft->run);
  return effect.is_gone ? "gone" : "stays";
}

void add_table_of(const Answer& answer, v1::Judgement& judgement) {
  if (!answer.is_in_draft) return;
  const std::string figure = answer.figure == nullptr ? "" : answer.figure->name;
  v1::Table& table = add_table(
      judgement, "remedy_" + answer.finding.code(),
      answer.finding.code() + (figure.empty() ? "" : ": " + figure + ", its worst value"));

  add_columns(table, {text_column("change", "change")});
  const double shown = answer.error.value_or(std::abs(answer.before.value_or(1.0)) * 0.05);
  add_columns(table, {number_column(
                         "figure", "worst", answer.figure == nullptr ? "" : unit_of(*answer.figure),
                         shown > 0.0 ? std::pow(10.0, std::floor(std::log10(shown))) : 1e-5)});
  // Two digits of the smallest error, as in the sentences.
  double finest = 1e-4;
  for (const Effect& effect : answer.effects)
    if (effect.curl && figures::mm_decimals(effect.curl->error_m) > 1) finest = 1e-5;
  add_columns(table, {
                         text_column("verdict", "difference"),
                         text_column("finding", "finding"),
                         number_column("curl_difference", "curl", "m", finest),
                     });
  table.mutable_columns()->rbegin()->set_is_signed(true);
  table.mutable_columns()->rbegin()->set_has_error(true);
  add_columns(table, {text_column("raised", "raised"), text_column("job", "")});

  add_row(table,
          {text_cell("the case itself"), answer.before ? number_cell(*answer.before) : v1::Cell(),
           v1::Cell(), code_cell("stays")});
  for (const Effect& effect : answer.effects) {
    const v1::StudyRun& run = effect.draft->run;
    std::vector<std::string> raised = effect.dangers;
    raised.insert(raised.end(), effect.warnings.begin(), effect.warnings.end());
    add_row(table,
            {text_cell(run.lever_step().words()),
             effect.value ? number_cell(*effect.value) : v1::Cell(),
             effect.value ? code_cell(code_of(effect.verdict)) : v1::Cell(),
             code_cell(outcome_of(effect)),
             effect.curl ? number_cell(effect.curl->end_m, effect.curl->error_m) : v1::Cell(),
             text_cell(joined(raised, ", ")), text_cell(run.job())});
  }
  if (answer.error && answer.figure != nullptr) {
    const std::string unit = unit_of(*answer.figure);
    table.set_note(fmt::format("a difference is known to {} {}: what the draft is off engineering",
                               figure_text(*answer.error, unit, answer.error),
                               plant_unit(unit).name()));
  }
}

}  // namespace

void judge_remedy(const StudyToJudge& study, v1::Judgement& judgement) {
  const Remedy remedy(study);
  if (remedy.base() == nullptr || remedy.base()->history.steps.empty()) {
    judgement.add_sentences(
        "The draft of the case itself has not run: there is nothing to compare with.");
    return;
  }

  const v1::RemedyPlan& plan = study.result.study().remedy();
  if (plan.has_experience()) {
    judgement.add_sentences(
        "All drafts have the data of the casting in the middle of those that what was cast leaves "
        "possible.");
    add_conditions(plan.experience(), judgement);
  }
  for (const v1::Finding& finding : plan.findings()) {
    const Answer answer = remedy.answer(finding);
    add_sentences(answer, judgement);
    add_table_of(answer, judgement);
  }
}

}  // namespace dccast::judging
