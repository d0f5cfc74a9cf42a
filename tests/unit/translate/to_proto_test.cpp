#include <gmock/gmock.h>
#include <google/protobuf/text_format.h>
#include <google/protobuf/util/message_differencer.h>

#include <bit>
#include <cmath>

#include "core/casting/findings/rules.hpp"
#include "core/results/step_report.hpp"
#include "proto/case_file/remedies.hpp"
#include "server/translate/translate.hpp"

namespace dccast::translate {
namespace {

/// A new finding needs its row in proto/case_file/remedies.cpp.
TEST(FindingToProto, EveryCodeHasItsRowOfLevers) {
  for (const auto& rule : casting::step_rules())
    EXPECT_TRUE(case_file::has_advice_row(rule.code)) << rule.code;
  for (const auto& rule : casting::case_rules())
    EXPECT_TRUE(case_file::has_advice_row(rule.code)) << rule.code;
}

TEST(FindingToProto, HasItsRemedy) {
  results::Finding finding;
  finding.code = "no_superheat";
  EXPECT_EQ(to_proto(finding).remedy(), "Pour hotter.");
}

TEST(StepToProto, NamesTheMonitors) {
  results::StepReport report;
  report.step = 3;
  report.cast_length = 0.5;
  report.monitor_displacement = {{1.0, 2.0}, {3.0, 4.0}};
  report.monitor_temperature = {600.0, std::nan("")};  // the second one is not poured yet
  const auto to = to_proto(report, {{"centre", 0, 0}, {"corner", 1, 0}});

  EXPECT_EQ(to.step(), 3);
  EXPECT_EQ(to.cast_length_m(), 0.5);
  ASSERT_EQ(to.monitors_size(), 2);
  EXPECT_EQ(to.monitors(1).name(), "corner");
  EXPECT_EQ(to.monitors(1).displacement_m(1), 4.0);
  EXPECT_EQ(to.monitors(0).temperature_c(), 600.0);
  EXPECT_FALSE(to.monitors(1).has_temperature_c());
}

TEST(StepToProto, KeepsHowFarTheSolidMovedAndTheMark) {
  results::StepReport report;
  report.beyond_validity = true;
  report.maximum_rotation = 0.1;
  report.bottom_slip = 0.02;
  report.shell_at_water_line = 0.03;
  report.bottom_shell = 0.04;
  report.mush_strain = 0.05;
  const auto to = to_proto(report, {});

  EXPECT_EQ(to.shell_at_water_line_m(), 0.03);
  EXPECT_EQ(to.bottom_shell_m(), 0.04);
  EXPECT_EQ(to.mush_strain(), 0.05);
  EXPECT_TRUE(to.beyond_validity());
  EXPECT_EQ(to.maximum_rotation_rad(), 0.1);
  EXPECT_EQ(to.bottom_slip_m(), 0.02);
}

/// Per metre of face in a section, the whole quarter's in three dimensions.
TEST(StepToProto, HeatAndForcesStandOnceAndSayOfWhatTheyAre) {
  results::StepReport report;
  report.side_heat = 3.0;
  report.weight = 5.0;
  const auto section = to_proto(report, {});
  EXPECT_EQ(section.section().side_heat(), 3.0);
  EXPECT_EQ(section.section().weight(), 5.0);
  EXPECT_EQ(section.section().extent(), v1::SectionFigures::METRE_OF_FACE);
  report.dimension = 3;
  const auto quarter = to_proto(report, {});
  EXPECT_EQ(quarter.section().side_heat(), 3.0);
  EXPECT_EQ(quarter.section().weight(), 5.0);
  EXPECT_EQ(quarter.section().extent(), v1::SectionFigures::WHOLE_QUARTER);
}

/// A mesh of a quarter slab that is finer bends more: the error has one side.
TEST(StepToProto, CurlsHaveTheErrorOfMeshAndStepsOnTheirSides) {
  results::StepReport report;
  report.monitor_displacement = {{1.0, 0.02}, {1.0, -0.02}, {1.0, std::nan("")}, {1.0}};
  const std::vector<casting::Monitor> monitors{{"up"}, {"down"}, {"dry"}, {"flat"}};

  v1::RelativeError error;
  error.set_upper(0.1);
  const auto to = to_proto(report, monitors, {error, error, error, error});
  EXPECT_EQ(to.monitors(0).curl_m(), 0.02);
  EXPECT_EQ(to.monitors(0).curl_lower_error_m(), 0.0);
  EXPECT_DOUBLE_EQ(to.monitors(0).curl_upper_error_m(), 0.002);
  EXPECT_DOUBLE_EQ(to.monitors(1).curl_lower_error_m(), 0.002) << "more is further down";
  EXPECT_EQ(to.monitors(1).curl_upper_error_m(), 0.0);
  EXPECT_FALSE(to.monitors(2).has_curl_m() || to.monitors(3).has_curl_m());

  const auto partly = to_proto(report, monitors, {std::nullopt, error});
  EXPECT_TRUE(partly.monitors(0).has_curl_m());
  EXPECT_FALSE(partly.monitors(0).has_curl_upper_error_m());
  EXPECT_TRUE(partly.monitors(1).has_curl_upper_error_m());
  EXPECT_FALSE(to_proto(report, monitors).monitors(1).has_curl_upper_error_m());
}

/// The results of a resumed run are made of what is read back: every bit counts.
TEST(StepToProto, IsReadBackExactly) {
  for (const int dimension : {2, 3}) {
    results::StepReport report;
    report.dimension = dimension;
    double value = 0.0;
    for (const results::HistoryField& field : results::history_fields()) {
      value += 1.0 / 3.0;
      if (field.real())
        results::set_value(field, report, value);
      else
        results::set_value(field, report, field.member.index() == 3 ? 1 : 7);  // 3: bool
    }
    report.monitor_displacement = {{-0.0, 1.0 / 7.0}, {std::nan(""), std::nan("")}};
    report.monitor_temperature = {600.0 + 1.0 / 3.0, std::nan("")};
    report.solver_seconds = 0.1;
    report.process_seconds = 0.3;
    auto sent = to_proto(report, {{"a", 0, 0}, {"b", 1, 0}});
    v1::StepReport received;
    ASSERT_TRUE(received.ParseFromString(sent.SerializeAsString()));
    results::StepReport back = to_core(received, dimension);
    EXPECT_EQ(std::bit_cast<std::uint64_t>(back.monitor_displacement[0][0]),
              std::bit_cast<std::uint64_t>(-0.0));
    for (const double never : {back.monitor_displacement[1][1], back.monitor_temperature[1]})
      EXPECT_EQ(std::bit_cast<std::uint64_t>(never), std::bit_cast<std::uint64_t>(std::nan("")));
    back.monitor_displacement[1] = report.monitor_displacement[1] = {};  // not equal to themselves
    back.monitor_temperature[1] = report.monitor_temperature[1] = 0.0;
    EXPECT_EQ(back, report);
  }
}

TEST(ValidityLossToProto, KeepsEveryField) {
  for (const auto& [name, kind] :
       {std::pair{"shell_melted_through", v1::Finding::SHELL_MELTED_THROUGH},
        std::pair{"motion_too_large", v1::Finding::MOTION_TOO_LARGE}}) {
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

TEST(FindingToProto, KeepsEveryFieldAndWhatIsAbsent) {
  const auto to = to_proto(results::Finding{"hot_tears",
                                            results::Severity::danger,
                                            "Tears.",
                                            12.5,
                                            {0.2, 0.1},
                                            0.02,
                                            0.005,
                                            "1",
                                            "plausibility.x",
                                            results::Exceedance{15.0, 0.03, {0.3, 0.2}},
                                            results::Certainty::likely,
                                            0.01,
                                            0.04});
  EXPECT_EQ(to.code(), "hot_tears");
  EXPECT_EQ(to.severity(), v1::Finding::DANGER);
  EXPECT_EQ(to.message(), "Tears.");
  EXPECT_EQ(to.time_s(), 12.5);
  ASSERT_EQ(to.place_m_size(), 2);
  EXPECT_EQ(to.place_m(1), 0.1);
  EXPECT_EQ(to.value(), 0.02);
  EXPECT_EQ(to.limit(), 0.005);
  EXPECT_EQ(to.unit(), "1");
  EXPECT_EQ(to.key(), "plausibility.x");
  EXPECT_EQ(to.worst().time_s(), 15.0);
  EXPECT_EQ(to.worst().value(), 0.03);
  ASSERT_EQ(to.worst().place_m_size(), 2);
  EXPECT_EQ(to.worst().place_m(1), 0.2);
  EXPECT_EQ(to.certainty(), v1::Finding::LIKELY);
  EXPECT_EQ(to.lower_error(), 0.01);
  EXPECT_EQ(to.upper_error(), 0.04);

  const auto bare = to_proto(results::Finding{});
  EXPECT_FALSE(bare.has_time_s() || bare.has_value() || bare.has_limit() || bare.has_worst() ||
               bare.has_upper_error());
  EXPECT_EQ(bare.certainty(), v1::Finding::CERTAINTY_UNSPECIFIED);
}

TEST(FailureToProto, KeepsTheCauseAndListsWhatFollowed) {
  using casting::FailureKind;
  const auto to = to_proto(
      {{FailureKind::shell_melted_through, "m", 1.0, 2.0, {0.2, 0.1}, {}, "shell_melted_through"},
       {FailureKind::storage, "disk full", 1.0, 0.0, {}, {}}});
  EXPECT_EQ(to.kind(), v1::Finding::SHELL_MELTED_THROUGH);
  EXPECT_EQ(to.message(), "m");
  EXPECT_EQ(to.code(), "shell_melted_through");
  EXPECT_EQ(to.time_s(), 1.0);
  EXPECT_EQ(to.time_step_s(), 2.0);
  ASSERT_EQ(to.place_m_size(), 2);
  EXPECT_EQ(to.place_m(0), 0.2);
  ASSERT_EQ(to.further_size(), 1);
  EXPECT_EQ(to.further(0).kind(), v1::Finding::STORAGE);
  EXPECT_EQ(to.further(0).message(), "disk full");
}

TEST(FailureToProto, KeepsTheResiduals) {
  const auto to = to_proto({{casting::FailureKind::solve_failed, "m", 1.0, 2.0, {}, {3.0, 4.0}}});
  EXPECT_EQ(to.kind(), v1::Finding::SOLVE_FAILED);
  ASSERT_EQ(to.residual_history_size(), 2);
  EXPECT_EQ(to.residual_history(1), 4.0);
}

// A mesh file is of any encoding; a message takes UTF-8 alone.
TEST(CheckToProto, WritesOutBytesThatAreNoUtf8) {
  casting::CheckedCase checked;
  checked.faults.add("mesh.file", "slab.msh", "has no group bott\xe9m");
  EXPECT_EQ(to_proto(checked).faults(0).message(), "has no group bott\\x{E9}m");
  EXPECT_EQ(describe(checked.faults.list()), "mesh.file = slab.msh: has no group bott\\x{E9}m");
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
  EXPECT_EQ(describe(checked.faults.list()), "monitor[0].y = 7: is outside (0 to 1 m)");
}

/// A frame of one quadrilateral in which every quantity that a v1::Frame holds has values of its
/// own, none of them zero.
results::Frame full_frame() {
  results::Frame frame;
  frame.time = 2.0;
  frame.cast_length = 3.0;
  frame.metal_level = 4.0;
  frame.dimension = 2;
  frame.nodes_per_element = 4;
  frame.node = {0.1, 0.2, 1.1, 0.3, 1.2, 1.3, 0.4, 1.4};
  frame.element_node = {3, 2, 1, 0};
  frame.temperature = {20, 21, 22, 23};
  frame.displacement = {0.01, 0.02, 0.03, 0.04, 0.05, 0.06, 0.07, 0.08};
  frame.bottom_node = {1, 3};
  frame.bottom_gap = {0.5e-3, 1e-3};
  frame.bottom_pressure = {7e3, 8e3};
  return frame;
}

v1::Frame expected_frame() {
  v1::Frame frame;
  const bool parsed = google::protobuf::TextFormat::ParseFromString(
      "time_s: 2 cast_length_m: 3 metal_level_m: 4 dimension: 2 nodes_per_element: 4 "
      "node_m: [0.1, 0.2, 1.1, 0.3, 1.2, 1.3, 0.4, 1.4] element_node: [3, 2, 1, 0] "
      "temperature_c: [20, 21, 22, 23] "
      "displacement_m: [0.01, 0.02, 0.03, 0.04, 0.05, 0.06, 0.07, 0.08] "
      "bottom_node: [1, 3] bottom_gap_m: [0.5e-3, 1e-3] bottom_pressure_pa: [7e3, 8e3] "
      "liquidus_c: 650 solidus_c: 600 shell_c: 610",
      &frame);
  EXPECT_TRUE(parsed);
  return frame;
}

TEST(FrameToProto, KeepsEveryField) {
  results::RunHeader header;
  header.liquidus = 650;
  header.solidus = 600;
  header.shell = 610;
  v1::Frame to = to_proto(full_frame(), header);
  // Fields that can be asked for by name; `field` is one that was.
  std::vector<std::string> names;
  for (const v1::FrameField& field : to.fields()) names.push_back(field.name());
  EXPECT_THAT(names, testing::ElementsAre("contact_pressure_pa", "gap_m"));
  to.clear_fields();

  // A field added to the message must be filled, and expected above; a drawing has the skin.
  v1::Frame drawn = to;
  make_drawing(drawn);
  const auto& fields = *v1::Frame::descriptor();
  for (int i = 0; i < fields.field_count(); ++i) {
    const auto* field = fields.field(i);
    if (field->name() == "field" || field->name() == "fields") continue;
    EXPECT_TRUE(field->is_repeated() ? drawn.GetReflection()->FieldSize(drawn, field) > 0
                                     : drawn.GetReflection()->HasField(drawn, field))
        << field->name();
  }
  std::string difference;
  google::protobuf::util::MessageDifferencer differencer;
  differencer.ReportDifferencesToString(&difference);
  EXPECT_TRUE(differencer.Compare(expected_frame(), to)) << difference;
}

}  // namespace
}  // namespace dccast::translate
