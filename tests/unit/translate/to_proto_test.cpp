#include <gtest/gtest.h>

#include "server/translate/faults_to_proto.hpp"
#include "server/translate/frame_to_proto.hpp"
#include "server/translate/step_to_proto.hpp"

namespace dccast::translate {
namespace {

TEST(StepToProto, NamesTheMonitors) {
  results::StepReport report;
  report.step = 3;
  report.cast_length = 0.5;
  report.monitor_displacement = {{1.0, 2.0}, {3.0, 4.0}};
  report.liquid_pressure_error = 7.0;
  const auto to = to_proto(report, {{"centre", 0, 0}, {"corner", 1, 0}});
  EXPECT_EQ(to.step(), 3);
  EXPECT_EQ(to.cast_length_m(), 0.5);
  ASSERT_EQ(to.monitors_size(), 2);
  EXPECT_EQ(to.monitors(1).name(), "corner");
  EXPECT_EQ(to.monitors(1).displacement_m(1), 4.0);
  EXPECT_EQ(to.liquid_pressure_error(), 7.0);
}

TEST(StepToProto, KeepsHowFarTheSolidMovedAndTheMark) {
  results::StepReport report;
  report.beyond_validity = true;
  report.maximum_rotation = 0.1;
  report.bottom_slip = 0.02;
  const auto to = to_proto(report, {});
  EXPECT_TRUE(to.beyond_validity());
  EXPECT_EQ(to.maximum_rotation_rad(), 0.1);
  EXPECT_EQ(to.bottom_slip_m(), 0.02);
}

TEST(ValidityLossToProto, KeepsEveryField) {
  for (const auto& [name, kind] :
       {std::pair{"shell_melted_through", v1::Failure::SHELL_MELTED_THROUGH},
        std::pair{"motion_too_large", v1::Failure::MOTION_TOO_LARGE},
        std::pair{"liquid_pressure_lost", v1::Failure::LIQUID_PRESSURE_LOST}}) {
    const auto to =
        to_proto(results::ValidityLoss{name, "it slid", 166.0, {0.2, 0.1}, 0.1, 0.02, "m"});
    EXPECT_EQ(to.kind(), kind);
    EXPECT_EQ(to.message(), "it slid");
    EXPECT_EQ(to.time_s(), 166.0);
    ASSERT_EQ(to.place_m_size(), 2);
    EXPECT_EQ(to.place_m(1), 0.1);
    EXPECT_EQ(to.value(), 0.1);
    EXPECT_EQ(to.limit(), 0.02);
    EXPECT_EQ(to.unit(), "m");
  }
}

TEST(FailureToProto, KeepsTheCauseAndListsWhatFollowed) {
  using casting::FailureKind;
  const auto to = to_proto({{FailureKind::shell_melted_through, "m", 1.0, 2.0, {0.2, 0.1}, {}},
                            {FailureKind::storage, "disk full", 1.0, 0.0, {}, {}}});
  EXPECT_EQ(to.kind(), v1::Failure::SHELL_MELTED_THROUGH);
  EXPECT_EQ(to.message(), "m");
  EXPECT_EQ(to.time_s(), 1.0);
  EXPECT_EQ(to.time_step_s(), 2.0);
  ASSERT_EQ(to.place_m_size(), 2);
  EXPECT_EQ(to.place_m(0), 0.2);
  ASSERT_EQ(to.further_causes_size(), 1);
  EXPECT_EQ(to.further_causes(0), "STORAGE: disk full");
}

TEST(FailureToProto, KeepsTheResiduals) {
  const auto to = to_proto({{casting::FailureKind::solve_failed, "m", 1.0, 2.0, {}, {3.0, 4.0}}});
  EXPECT_EQ(to.kind(), v1::Failure::SOLVE_FAILED);
  ASSERT_EQ(to.residual_history_size(), 2);
  EXPECT_EQ(to.residual_history(1), 4.0);
}

TEST(CheckToProto, GivesAnEstimateOnlyWithoutFaults) {
  casting::CheckedCase checked;
  checked.estimate.nodes = 12;
  checked.warnings.add("a", 1.0, "w");
  EXPECT_EQ(to_proto(checked).estimate().nodes(), 12);
  EXPECT_EQ(to_proto(checked).warnings_size(), 1);
  checked.faults.add("monitor[0].y", 7.0, "is outside", "0 to 1 m", "move it");
  const auto verdict = to_proto(checked);
  EXPECT_FALSE(verdict.has_estimate());
  EXPECT_EQ(verdict.faults(0).remedy(), "move it");
  EXPECT_EQ(in_words(checked.faults.list()), "monitor[0].y = 7: is outside (0 to 1 m)");
}

TEST(FrameToProto, KeepsEveryField) {
  results::Frame frame;
  frame.time = 2.0;
  frame.node = {0, 0, 1, 0, 0, 1};
  frame.element_node = {0, 1, 2};
  frame.temperature = {20, 21, 22};
  frame.bottom_gap = {0.0, 1e-3};
  results::RunHeader header;
  header.solidus = 600;
  const auto to = to_proto(frame, header);
  EXPECT_EQ(to.node_m_size(), 6);
  EXPECT_EQ(to.element_node(2), 2);
  EXPECT_EQ(to.temperature_c(1), 21);
  EXPECT_EQ(to.bottom_gap_m(1), 1e-3);
  EXPECT_EQ(to.solidus_c(), 600);
  EXPECT_EQ(to.dimension(), 2);
}

}  // namespace
}  // namespace dccast::translate
