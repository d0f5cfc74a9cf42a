#include "server/state/check.hpp"

#include <gmock/gmock.h>

#include <sstream>

#include "core/storage/file.hpp"
#include "server/jobs/logs/readings_log.hpp"
#include "server/studies/lines.hpp"
#include "tests/unit/state/state_folder_fixture.hpp"

namespace dccast::state {
namespace {

using ::testing::HasSubstr;

/// A job that follows a casting, with three readings.
class CheckOfReadings : public StateFolderTest {
protected:
  CheckOfReadings() {
    jobs::create_readings_log(job_, {});
    google::protobuf::RepeatedPtrField<v1::Reading> readings;
    for (int number = 1; number <= 3; ++number) {
      readings.Add()->set_number(number);
      readings[number - 1].set_time_s(number);
    }
    jobs::ReadingsLog(job_).append(readings);
    store_.reset();
  }

  std::string found(bool repair = false) {
    std::ostringstream out;
    damages_ = check(folder_, {.repair = repair}, out);
    return out.str();
  }

  const std::filesystem::path job_ = folder_.jobs() / add_job();
  const std::filesystem::path record_ = job_ / jobs::readings_file;
  int damages_ = 0;
};

TEST_F(CheckOfReadings, FindsNothingInASoundRecord) {
  EXPECT_THAT(found(), ::testing::Not(HasSubstr("readings.log")));
  EXPECT_EQ(damages_, 0);
}

TEST_F(CheckOfReadings, SetsATornReadingAside) {
  std::filesystem::resize_file(record_, std::filesystem::file_size(record_) - 1);
  EXPECT_THAT(found(), HasSubstr("bytes that are no reading"));
  EXPECT_EQ(damages_, 0) << "it was not acknowledged";

  EXPECT_THAT(found(true), HasSubstr("repaired"));
  EXPECT_THAT(found(), ::testing::Not(HasSubstr("readings.log")));
  EXPECT_EQ(jobs::ReadingsLog(job_).state().number(), 2);
}

TEST_F(CheckOfReadings, AReadingThatIsDamagedBeforeOthersIsDamage) {
  std::string bytes = storage::read_file(record_);
  bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 1);
  storage::write_file(record_, bytes);
  EXPECT_THAT(found(true), HasSubstr("and readings follow"));
  EXPECT_EQ(damages_, 1);
}

TEST_F(CheckOfReadings, ALineThatIsDamagedIsReported) {
  studies::Lines lines(folder_.lines());
  v1::LineCasting casting;
  casting.set_job("job-1");
  lines.reserve("line-1", "anna").add(casting);
  EXPECT_THAT(found(), ::testing::Not(HasSubstr("line line-1")));
  storage::write_file(folder_.lines() / "line-1.bin", "nothing of ours");
  EXPECT_THAT(found(), HasSubstr("line line-1: its file is damaged"));
  EXPECT_EQ(damages_, 1);
}

TEST_F(CheckOfReadings, ReportsARecordWhoseHeaderIsDamaged) {
  storage::write_file(record_, "DCCASTRD, but not for long enough");
  EXPECT_THAT(found(true), HasSubstr("the header is damaged"));
  EXPECT_EQ(damages_, 1);
}

}  // namespace
}  // namespace dccast::state
