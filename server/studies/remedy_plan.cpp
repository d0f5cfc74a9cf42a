// What helps against the findings of a job: drafts of its case with one lever moved at a time.
#include <algorithm>

#include "proto/case_file/override.hpp"
#include "proto/case_file/quality.hpp"
#include "proto/case_file/remedies.hpp"
#include "server/intake/case_intake.hpp"
#include "server/studies/study_plan.hpp"

namespace dccast::studies {

namespace {

/// The case as a draft; then, where mesh and steps follow the quality, the case at engineering,
/// which shows what a figure of a draft is worth; then the levers.
class RemedyStudy final : public StudyPlan {
public:
  explicit RemedyStudy(const v1::CreateStudyRequest& request)
      : base_(request.case_()), has_companion_(case_file::quality_matters(request.case_())) {
    if (has_companion_) base_.set_quality(v1::DRAFT);
    const auto& data = request.remedy().data();
    case_file::apply_changes(base_, {data.begin(), data.end()});
    for (const case_file::Advice& advice : case_file::advice_against(request.remedy().findings()))
      std::ranges::move(case_file::lever_drafts(advice, base_), std::back_inserter(drafts_));
  }

  int runs() const override { return first_lever() + static_cast<int>(drafts_.size()); }

  PlannedRun run(int number) const override {
    if (number == 0) return planned(number, "the case itself, draft", base_, {});
    if (number < first_lever()) {
      v1::Case finer = base_;
      finer.set_quality(v1::ENGINEERING);
      return planned(number, "the case itself, engineering", finer, {});
    }
    const case_file::LeverDraft& draft = drafts_[number - first_lever()];
    return planned(number, draft.step.words(), base_, draft.changes);
  }

  void describe(int number, v1::StudyRun& run) const override {
    if (number >= first_lever()) *run.mutable_lever_step() = drafts_[number - first_lever()].step;
    if (const auto error = mesh_error(this->run(number).description))
      *run.mutable_mesh_error() = *error;
  }

private:
  int first_lever() const { return has_companion_ ? 2 : 1; }

  v1::Case base_;
  bool has_companion_;
  std::vector<case_file::LeverDraft> drafts_;
};

}  // namespace

std::vector<v1::Fault> remedy_faults(const v1::CreateStudyRequest& request) {
  if (!case_file::advice_against(request.remedy().findings()).empty()) return {};
  return {intake::fault_of("remedy.job", request.remedy().job(),
                           "has no finding that a lever of the plant influences",
                           "an ended job with such a finding (docs/findings.md)")};
}

std::unique_ptr<StudyPlan> remedy_plan(const v1::CreateStudyRequest& request) {
  return std::make_unique<RemedyStudy>(request);
}

}  // namespace dccast::studies
