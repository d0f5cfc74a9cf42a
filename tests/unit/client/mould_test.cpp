#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/html/pages.hpp"
#include "client/text/study_text.hpp"

namespace dccast::client::render {
namespace {

using testing::HasSubstr;
using testing::Not;

/// Two runs: a rectangle whose slab is 20 mm hollow, and the mould that was found.
MouldDesign design_of(double residual_m, bool within) {
  MouldDesign design;
  design.wanted_m = 0.285;
  v1::Study& study = *design.result.mutable_study();
  study.set_id("the-study");
  study.set_title("a slab <flat>");
  study.set_state(v1::STUDY_SUCCEEDED);
  study.set_runs(2);
  study.mutable_mould()->set_tolerance_m(0.5e-3);
  v1::StudyResult::MouldFound& found = *design.result.mutable_mould();
  for (const double x : {0.0, 0.2, 0.42, 0.66}) found.add_x_m(x);
  for (const double half : {0.304, 0.304, 0.298, 0.2908}) found.add_half_opening_m(half);
  found.set_residual_m(residual_m);
  found.set_within_tolerance(within);
  MouldRun first{"job-1", v1::SUCCEEDED, CastMould{}, ""};
  first.cast->face = {0.8, 0.1e-3, {0.0, 0.66}, {0.285, 0.285}, {0.265, 0.279}};
  MouldRun second{"job-2", v1::SUCCEEDED, CastMould{}, ""};
  *second.cast->section.mutable_half_thickness_m()->mutable_at() = found.x_m();
  *second.cast->section.mutable_half_thickness_m()->mutable_value() = found.half_opening_m();
  second.cast->face = {0.8, 0.1e-3, {0.0, 0.66}, {0.304, 0.2908}, {0.285 - residual_m, 0.285}};
  design.runs = {first, second};
  return design;
}

TEST(MouldText, SaysInPlainWordsWhatWasFound) {
  const std::string text = mould_text(design_of(0.3e-3, true));
  EXPECT_THAT(text, HasSubstr("half-openings of 304.00 mm from the middle to 200 mm, 298.00 mm at "
                              "420 mm, 290.80 mm at 660 mm"));
  EXPECT_THAT(text, HasSubstr("flat within 0.30 mm (tolerance 0.50 mm), after 2 runs."));
  EXPECT_THAT(text, HasSubstr("0, 200, 420, 660"));
  EXPECT_THAT(text, HasSubstr("20.00")) << "what the first run was off";
  EXPECT_THAT(text, HasSubstr("6.7 %")) << "open over what is wanted";
  EXPECT_THAT(text, Not(HasSubstr("not steady")));
}

TEST(MouldText, SaysWhyItIsNotFlat) {
  MouldDesign design = design_of(0.8e-3, false);
  EXPECT_THAT(mould_sentence(design), HasSubstr("three straight segments cannot come closer"));

  design.result.mutable_study()->mutable_mould()->set_maximum_runs(2);
  EXPECT_THAT(mould_sentence(design), HasSubstr("these were all the runs permitted"));

  design.result.mutable_study()->set_state(v1::STUDY_RUNNING);
  EXPECT_THAT(mould_sentence(design), HasSubstr("within 0.80 mm of flat so far"));

  design.runs[1].cast->face.change_m = 0.9e-3;
  EXPECT_THAT(mould_sentence(design), HasSubstr("not steady yet and may contract further"));

  design.runs[1].cast.reset();
  design.runs[1].reason = "it melted through";
  EXPECT_THAT(mould_text(design), HasSubstr("run 2: it melted through"));

  design.runs.clear();
  EXPECT_THAT(mould_text(design), HasSubstr("No run has shown a cold slab yet"));
}

TEST(MouldPage, ShowsMouldAndSlabOfEveryRun) {
  const std::string page = mould_page(design_of(0.3e-3, true));
  EXPECT_THAT(page, HasSubstr("a slab &lt;flat&gt;"));
  EXPECT_THAT(page, HasSubstr("Half-opening of the mould"));
  EXPECT_THAT(page, HasSubstr("Cold slab"));
  EXPECT_THAT(page, HasSubstr("run 2"));
}

}  // namespace
}  // namespace dccast::client::render
