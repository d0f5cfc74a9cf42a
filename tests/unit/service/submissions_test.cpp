// What a submission is refused for, and what becomes of one that is not.
#include <gmock/gmock.h>

#include "tests/unit/service/service_fixture.hpp"

namespace dccast::service {
namespace {

using ::testing::ElementsAre;
using ::testing::ElementsAreArray;
using ::testing::HasSubstr;
using ::testing::Not;
using enum grpc::StatusCode;

const std::string elsewhere = "0f2b9a4e-0000-4000-8000-000000000000";

std::vector<std::string> fields(const v1::ValidateCaseResponse& verdict) {
  std::vector<std::string> names;
  for (const v1::Fault& fault : verdict.faults()) names.push_back(fault.field());
  return names;
}

class SubmissionTest : public ServiceTest {
protected:
  using ServiceTest::ServiceTest;

  /// What `dccast validate` shows of a case.
  v1::ValidateCaseResponse validated(const v1::Case& submitted,
                                     const std::vector<v1::Attachment>& files = {}) {
    v1::ValidateCaseRequest request;
    *request.mutable_case_() = submitted;
    request.mutable_attachments()->Assign(files.begin(), files.end());
    return user_.ask(&Stub::ValidateCase, request);
  }
  /// A fault of the core, which sees the case as a whole.
  void find_faults_of_the_whole() {
    v1::ValidateCaseResponse verdict;
    for (const char* field : {"monitor[0].y", "limits.maximum_steps"}) {
      verdict.add_faults()->set_field(field);
      verdict.mutable_faults()->rbegin()->set_message("is beside the slab");
    }
    set_verdict(verdict);
  }

  User user_ = local_user();
};
/// The refusal of a submission with a code, by the user of this process.
#define REFUSED(code, request) user_.refusal(code, &Stub::SubmitJob, request).error_message()

TEST_F(SubmissionTest, IdsThatAreNone) {
  for (const std::string& id : {std::string(), std::string("7"), std::string("../../etc"),
                                std::string(1000, 'x'), std::string("éééééééééééééééééééééééééé"),
                                std::string("0F2B9A4E-0000-4000-8000-000000000000")}) {
    user_.refusal(INVALID_ARGUMENT, &Stub::GetJob, of<v1::GetJobRequest>(id));
    user_.refusal(INVALID_ARGUMENT, &Stub::WatchJob, of<v1::WatchJobRequest>(id));
    user_.refusal(INVALID_ARGUMENT, &Stub::CancelJob, of<v1::CancelJobRequest>(id));
    if (id.empty()) continue;  // a job of no study

    v1::SubmitJobRequest request = submission();
    request.set_study(id);
    EXPECT_THAT(REFUSED(INVALID_ARGUMENT, request), HasSubstr("not a study id"));
    v1::ListJobsRequest list;
    list.set_study(id);
    user_.refusal(INVALID_ARGUMENT, &Stub::ListJobs, list);
  }
  EXPECT_TRUE(listed(user_).empty());
}

TEST_F(SubmissionTest, AnIdOfElsewhere) {
  const auto status = user_.refusal(NOT_FOUND, &Stub::GetJob, of<v1::GetJobRequest>(elsewhere));
  EXPECT_THAT(status.error_message(), HasSubstr("the list of jobs"));
  user_.refusal(NOT_FOUND, &Stub::WatchJob, of<v1::WatchJobRequest>(elsewhere));
  user_.refusal(NOT_FOUND, &Stub::FetchResult, of<v1::FetchResultRequest>(elsewhere));
  user_.refusal(NOT_FOUND, &Stub::QueryResult, of<v1::QueryResultRequest>(elsewhere));
}

TEST_F(SubmissionTest, ASequenceBeyondTheLog) {
  auto request = of<v1::WatchJobRequest>(ended_job(user_).id());
  request.set_from_sequence(1000);
  user_.refusal(OUT_OF_RANGE, &Stub::WatchJob, request);
}

TEST_F(SubmissionTest, AFullQueue) {
  submitted(user_);
  queue_.executor.wait_for_launch(1);
  for (int waiting = 0; waiting < 2; ++waiting) submitted(user_);
  const grpc::Status status = user_.refusal(RESOURCE_EXHAUSTED, &Stub::SubmitJob, submission());
  const auto facts = refusal::read_details(status.error_details()).value();
  EXPECT_EQ(facts.reason, v1::ErrorInfo::LIMIT_REACHED);
  EXPECT_EQ(facts.cause, "the queue is full");
  EXPECT_EQ(facts.limit, "limits.maximum_queued");
  EXPECT_EQ(facts.permitted, "2");
  EXPECT_EQ(facts.remedy, "submit again later");
}

TEST_F(SubmissionTest, ACaseWithFaults) {
  find_faults_of_the_whole();
  const grpc::Status status = user_.refusal(INVALID_ARGUMENT, &Stub::SubmitJob, submission());
  EXPECT_EQ(refusal::read_details(status.error_details())->reason, v1::ErrorInfo::INVALID_CASE);
  v1::ValidateCaseResponse verdict;
  ASSERT_TRUE(refusal::read_detail(status.error_details(), verdict));
  EXPECT_THAT(fields(verdict), ElementsAre("monitor[0].y", "limits.maximum_steps"));
  EXPECT_THAT(fields(validated(sound_case())), ElementsAreArray(fields(verdict)));
}

TEST_F(SubmissionTest, ValuesOutOfRangeAllAtOnceAndWithThoseOfTheWhole) {
  v1::SubmitJobRequest request = submission();
  v1::Case& faulty = *request.mutable_case_();
  faulty.mutable_section()->set_half_width_m(std::nan(""));
  faulty.mutable_mesh()->set_columns(-3);
  faulty.mutable_alloy()->set_card("unobtainium");
  EXPECT_THAT(fields(validated(faulty)),
              ::testing::IsSupersetOf({"section.half_width", "mesh.columns", "alloy.card"}));
  REFUSED(INVALID_ARGUMENT, request);

  find_faults_of_the_whole();
  v1::Case both = sound_case();
  both.mutable_mechanics()->set_tolerance(7.0);
  EXPECT_THAT(fields(validated(both)),
              ElementsAre("mechanics.tolerance", "monitor[0].y", "limits.maximum_steps"));
}

TEST_F(SubmissionTest, AnEmptyCase) {
  REFUSED(INVALID_ARGUMENT, v1::SubmitJobRequest());
}

/// A case may not permit itself more than the server does.
TEST_F(SubmissionTest, ACaseBeyondTheCeilingsOfTheServer) {
  v1::ValidateCaseResponse large;
  large.mutable_estimate()->set_nodes(1'000'001);
  large.mutable_estimate()->set_steps(1'000'001);
  large.mutable_estimate()->set_memory_bytes(1.1e12);
  set_verdict(large);
  v1::SubmitJobRequest request = submission();
  request.mutable_case_()->mutable_limits()->set_maximum_nodes(10'000'000);
  request.mutable_case_()->mutable_limits()->set_maximum_steps(100'000'000);

  const auto verdict = validated(request.case_());
  EXPECT_THAT(fields(verdict), ElementsAre("mesh", "time", "mesh"));
  std::vector<std::string> permitted;
  for (const v1::Fault& fault : verdict.faults()) {
    permitted.push_back(fault.permitted());
    EXPECT_FALSE(fault.value().empty() || fault.remedy().empty()) << fault.field();
  }
  EXPECT_THAT(permitted, ElementsAre("at most 1000000", "at most 1000000", "at most 1e+03 GB"));
  EXPECT_FALSE(verdict.has_estimate());
  REFUSED(INVALID_ARGUMENT, request);

  const auto info = user_.ask(&Stub::GetServerInfo, v1::GetServerInfoRequest());
  EXPECT_EQ(info.maximum_nodes(), 1'000'000);
  EXPECT_EQ(info.maximum_steps(), 1'000'000);
  EXPECT_EQ(info.maximum_memory_bytes(), 1e12);
}

TEST_F(SubmissionTest, TextsThatActOnATerminalOrALog) {
  const std::pair<std::string, const char*> texts[] = {{"\x1b]0;owned\x07", "ESC"},
                                                       {"a\nb", "line feed"},
                                                       {std::string("a\0b", 3), "NUL"},
                                                       {"\xc2\x9b"
                                                        "31m",
                                                        "CSI"},
                                                       {"x\u202egnp", "U+202E"},
                                                       {"\u2066x", "U+2066"}};
  const auto expect_refused = [&](const auto& text, const char* name, const auto& change) {
    v1::SubmitJobRequest request = submission();
    change(request);
    const std::string why = REFUSED(INVALID_ARGUMENT, request);
    EXPECT_THAT(why, Not(HasSubstr(text)));
    EXPECT_THAT(why, HasSubstr(name));
  };

  for (const auto& [text, name] : texts) {
    const auto in_case = [&](const char* names, auto&& change) {
      expect_refused(text, names, [&](auto& request) { change(*request.mutable_case_()); });
    };
    in_case(name, [&](v1::Case& c) { c.set_title("steps=1 " + text); });
    in_case("monitor[0].name", [&](v1::Case& c) { c.mutable_monitor(0)->set_name(text); });
    in_case("", [&](v1::Case& c) { c.mutable_cooling()->add_zone()->set_name(text); });
    in_case("", [&](v1::Case& c) { c.mutable_alloy()->set_card(text); });

    expect_refused(text, name, [&](auto& request) { request.set_request_id(text); });
    expect_refused(text, name, [&](auto& request) { request.add_labels(text); });
    // A name with NUL is no plain name of a file either.
    const v1::Attachment file = user_.uploaded(text, "x");
    expect_refused(text, "", [&](auto& request) { *request.add_attachments() = file; });
    if (text.find('\n') != std::string::npos) continue;  // the value of a key may have lines
    expect_refused(text, name, [&](auto& request) {
      v1::CaseChange& change = *request.add_changes();
      change.set_key("title");
      change.set_value(text);
    });
  }
}

TEST_F(SubmissionTest, LabelsAndChangesThatAreNone) {
  for (const auto& labels : {std::vector<std::string>{""},
                             {"two\nlines"},
                             {std::string(65, 'x')},
                             std::vector<std::string>(21, "a")}) {
    v1::SubmitJobRequest request = submission();
    request.mutable_labels()->Assign(labels.begin(), labels.end());
    REFUSED(INVALID_ARGUMENT, request);
  }
  v1::SubmitJobRequest request = submission();
  request.add_changes()->set_value(std::string(20'000, 'x'));
  REFUSED(INVALID_ARGUMENT, request);
}

TEST_F(SubmissionTest, ATimeLimitThatIsNone) {
  v1::SubmitJobRequest request = submission();
  for (const double limit : {-1.0, std::nan(""), std::numeric_limits<double>::infinity()}) {
    request.set_time_limit_s(limit);
    EXPECT_THAT(REFUSED(INVALID_ARGUMENT, request), HasSubstr("time_limit_s"));
  }
}

TEST_F(SubmissionTest, WhatComesAfterAJobThatCannotSucceed) {
  const std::string failed = submitted(user_).id();
  run_next_job({}, v1::RunEnd::FAILED);
  for (const auto& [before, code] :
       {std::pair(failed, FAILED_PRECONDITION), std::pair(elsewhere, NOT_FOUND),
        std::pair(std::string("last"), INVALID_ARGUMENT)}) {
    v1::SubmitJobRequest request = submission();
    request.add_after(before);
    REFUSED(code, request);
  }
}

TEST_F(SubmissionTest, FilesOfACase) {
  v1::SubmitJobRequest request = submission();
  for (const std::string& name : {std::string(), std::string(".."), std::string("a/b"),
                                  std::string("/etc/passwd"), std::string(300, 'x')}) {
    request.clear_attachments();
    *request.add_attachments() = user_.uploaded(name, "x");
    REFUSED(INVALID_ARGUMENT, request);
  }
  find_faults_of_the_whole();
  const auto verdict = validated(sound_case(), {user_.uploaded("a/b", "")});
  EXPECT_THAT(fields(verdict), ElementsAre("attachments"));
  EXPECT_TRUE(std::ranges::any_of(verdict.warnings(), [](const v1::Fault& warning) {
    return warning.field() == "attachments" && warning.message().find("wait") != std::string::npos;
  })) << "the rest of the case waits for its files";

  set_verdict({});
  request.clear_attachments();
  *request.add_attachments() = user_.uploaded("a", "x");
  *request.add_attachments() = request.attachments(0);
  REFUSED(INVALID_ARGUMENT, request);
  request.clear_attachments();
  request.mutable_case_()->mutable_mesh()->set_file("slab.msh");
  EXPECT_THAT(REFUSED(INVALID_ARGUMENT, request), HasSubstr("attachments"));

  *request.add_attachments() = user_.uploaded("slab.msh", "mesh");
  const v1::Job job = submitted(user_, request);
  EXPECT_EQ(storage::read_file(options_.jobs_directory / job.id() / "attachments" / "slab.msh"),
            "mesh");
  EXPECT_TRUE(std::filesystem::is_empty(folder_ / "check"));
}

TEST_F(SubmissionTest, TheSameRequestTwiceIsOneJobOfOneStudy) {
  v1::SubmitJobRequest request = submission();
  request.set_request_id("r");
  request.set_study(elsewhere);
  const std::string id = submitted(user_, request).id();
  EXPECT_EQ(submitted(user_, request).id(), id);

  v1::SubmitJobRequest other = request;
  other.mutable_case_()->mutable_time()->set_end_s(601.0);
  REFUSED(ALREADY_EXISTS, other);
  for (const char* study : {"", "0f2b9a4e-0000-4000-8000-000000000001"}) {
    other = request;
    other.set_study(study);
    EXPECT_THAT(REFUSED(ALREADY_EXISTS, other), HasSubstr("another study"));
  }
  EXPECT_THAT(listed(user_), ElementsAre(id));

  run_next_job({});
  user_.ask(&Stub::DeleteJob, of<v1::DeleteJobRequest>(id));
  EXPECT_NE(submitted(user_, request).id(), id);
}

class UnderACrashingCheck : public SubmissionTest {
protected:
  UnderACrashingCheck() : SubmissionTest({}, crashes) {}
};

TEST_F(UnderACrashingCheck, ItIsRefusedAsAFaultOfTheServer) {
  EXPECT_THAT(REFUSED(INTERNAL, submission()), HasSubstr("signal 6"));
}

}  // namespace
}  // namespace dccast::service
