#include "client/text/findings.hpp"

#include <unistd.h>

#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client_run.hpp"
#include "fake_service.hpp"
#include "proto/case_file/shipped.hpp"

namespace dccast::client {
namespace {

using testing::HasSubstr;

v1::Finding thin_shell() {
  v1::Finding finding;
  finding.set_code("bleed_out_at_exit");
  finding.set_severity(v1::Finding::DANGER);
  finding.set_message("The shell is thin <here>.");
  finding.set_time_s(15.0);
  finding.add_place_m(0.28);
  finding.add_place_m(0.045);
  finding.set_value(0.0012);
  finding.set_limit(0.005);
  finding.set_unit("m");
  finding.set_key("plausibility.minimum_shell");
  return finding;
}

v1::Finding remark() {
  v1::Finding finding;
  finding.set_code("remark");
  finding.set_severity(v1::Finding::NOTE);
  finding.set_message("Well.");
  return finding;
}

Findings list_of(std::initializer_list<v1::Finding> findings) {
  return {findings.begin(), findings.end()};
}

TEST(FindingLine, SaysAllThatIsKnownAndNothingElse) {
  EXPECT_EQ(
      finding_line(thin_shell()),
      "danger: bleed_out_at_exit at 15.00 s: The shell is thin <here>. dccast remedy computes "
      "what helps. [1.2 mm, limit 5 mm; x 280.0 mm, y 45.0 mm; plausibility.minimum_shell]");
  EXPECT_EQ(finding_line(remark()), "note: remark: Well.");
}

TEST(FindingLine, BeginsWithTheWorstExceedanceWhereItIsNotTheFirst) {
  v1::Finding finding = thin_shell();
  finding.mutable_worst()->set_time_s(15.0);
  finding.mutable_worst()->set_value(0.0012);
  EXPECT_EQ(finding_line(finding), finding_line(thin_shell()));
  finding.mutable_worst()->set_time_s(21.5);
  finding.mutable_worst()->set_value(0.0004);
  finding.mutable_worst()->add_place_m(0.27);
  finding.mutable_worst()->add_place_m(0.045);
  EXPECT_EQ(finding_line(finding),
            "danger: bleed_out_at_exit at 15.00 s: At worst 0.4 mm, at 21.50 s. The shell is thin "
            "<here>. dccast remedy computes what helps. [1.2 mm, limit 5 mm; x 280.0 mm, y 45.0 "
            "mm; worst at x 270.0 mm, y 45.0 mm; "
            "plausibility.minimum_shell]");
  EXPECT_THAT(findings_part(list_of({finding})),
              HasSubstr("<td>At worst 0.4 mm, at 21.50 s. The shell is thin &lt;here&gt;."));
}

TEST(FindingsCount, NamesTheGravestFirst) {
  EXPECT_EQ(findings_count({}), "");
  EXPECT_EQ(findings_count(list_of({remark(), thin_shell(), remark()})), "1 danger, 2 notes");
}

TEST(MoreThanNotes, IsWhatStrictFailsFor) {
  EXPECT_FALSE(more_than_notes(list_of({remark()})));
  EXPECT_TRUE(more_than_notes(list_of({remark(), thin_shell()})));
}

TEST(FindingsPart, HasTheGravestFirstAndNoMarkupOfTheirs) {
  EXPECT_THAT(findings_part({}), HasSubstr("Findings: none"));
  EXPECT_THAT(findings_part({}), HasSubstr("not a safety system"));
  const std::string part = findings_part(list_of({remark(), thin_shell()}));
  EXPECT_LT(part.find("bleed_out_at_exit"), part.find("remark"));
  EXPECT_THAT(part, HasSubstr("thin &lt;here&gt;"));
}

TEST(Validate, ShowsFindingsAndFailsForThemOnlyIfStrict) {
  FakeService service;
  *service.verdict.add_findings() = thin_shell();
  const auto path = std::filesystem::path(testing::TempDir()) /
                    ("dccast_findings_" + std::to_string(::getpid()) + ".toml");
  std::ofstream(path) << shipped::case_templates().back().text;
  const std::string file = path.string();
  const Result plain = dccast({"validate", file}, service.address());

  EXPECT_EQ(plain.code, 0) << plain.err;
  EXPECT_THAT(plain.out, HasSubstr("danger: bleed_out_at_exit"));
  EXPECT_EQ(dccast({"validate", "--strict", file}, service.address()).code, 2);
  EXPECT_THAT(dccast({"validate", "--json", file}, service.address()).out,
              HasSubstr("\"findings\":[{\"code\":\"bleed_out_at_exit\""));

  service.verdict.clear_findings();
  *service.verdict.add_findings() = remark();
  EXPECT_EQ(dccast({"validate", "--strict", file}, service.address()).code, 0);

  std::filesystem::remove(path);
}

}  // namespace
}  // namespace dccast::client
