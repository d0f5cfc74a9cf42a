#include "server/jobs/logs/readings_log.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "core/storage/file.hpp"
#include "server/jobs/folder/events.hpp"
#include "tests/support/eventually.hpp"
#include "tests/support/temporary_folder.hpp"

namespace dccast::jobs {
namespace {

using Readings = google::protobuf::RepeatedPtrField<v1::Reading>;

Readings readings(std::int64_t first, std::int64_t last) {
  Readings made;
  for (std::int64_t number = first; number <= last; ++number) {
    v1::Reading& reading = *made.Add();
    reading.set_number(number);
    reading.set_time_s(static_cast<double>(number));
    reading.set_casting_speed_m_per_s(1e-3);
  }
  return made;
}

class ReadingsLogTest : public ::testing::Test {
protected:
  void SetUp() override { create_readings_log(folder(), following()); }
  static v1::Following following() {
    v1::Following with;
    with.set_ensemble("study");
    return with;
  }
  /// Adds readings as their bytes, without the rate of append().
  void write_records(std::int64_t count) const {
    std::string bytes = storage::read_file(path());
    for (const v1::Reading& reading : readings(1, count)) {
      v1::RecordEntry entry;
      *entry.mutable_reading() = reading;
      bytes += storage::short_records.framed(entry.SerializeAsString());
    }
    storage::write_file(path(), bytes);
  }
  std::filesystem::path folder() const { return folder_ / ""; }
  std::filesystem::path path() const { return folder_ / readings_file; }

private:
  TemporaryFolder folder_;
};

TEST_F(ReadingsLogTest, IsReadWhileItGrows) {
  EXPECT_TRUE(follows_readings(folder()));
  ReadingsLog log(folder());
  ReadingsReader reader(folder());
  EXPECT_TRUE(reader.read_new().empty());
  EXPECT_EQ(reader.following().ensemble(), "study");

  log.append(readings(1, 3));
  EXPECT_EQ(reader.read_new().size(), 3u);
  log.append(readings(2, 5));
  const auto added = reader.read_new();
  ASSERT_EQ(added.size(), 2u) << "two and three were there already";
  EXPECT_EQ(added[0].number(), 4);
  EXPECT_EQ(added[1].time_s(), 5.0);
  EXPECT_EQ(log.state().number(), 5);
  EXPECT_EQ(log.state().time_s(), 5.0);
}

TEST_F(ReadingsLogTest, KeepsAllOrNothingOfACall) {
  ReadingsLog log(folder());
  log.append(readings(1, 2));
  EXPECT_THROW(log.append(readings(4, 5)), MissingReading);

  Readings back = readings(3, 4);
  back.Mutable(1)->set_time_s(3.0);
  EXPECT_THROW(log.append(back), UnfitReading);
  EXPECT_EQ(log.state().number(), 2);
  EXPECT_EQ(ReadingsReader(folder()).read_new().size(), 2u);
}

TEST_F(ReadingsLogTest, KnowsWhenTheLastReadingArrived) {
  ReadingsReader reader(folder());
  reader.read_new();
  EXPECT_FALSE(reader.last_arrival());

  const auto before = milliseconds(now());
  ReadingsLog(folder()).append(readings(1, 2));
  reader.read_new();
  ASSERT_TRUE(reader.last_arrival());
  EXPECT_GE(milliseconds(*reader.last_arrival()), before);
  EXPECT_LE(milliseconds(*reader.last_arrival()), milliseconds(now()));
}

TEST_F(ReadingsLogTest, TakesNothingAfterItsEnd) {
  ReadingsLog log(folder());
  log.append(readings(1, 1));
  Readings end;
  end.Add()->set_number(2);
  end.Mutable(0)->set_closes(true);
  log.append(end);
  EXPECT_TRUE(log.state().closed());
  EXPECT_THROW(log.append(readings(3, 3)), UnfitReading);
  log.append(readings(1, 1));  // a repeated call
}

TEST_F(ReadingsLogTest, GoesOnBehindTheLastWholeReading) {
  ReadingsLog(folder()).append(readings(1, 4));
  std::filesystem::resize_file(path(), std::filesystem::file_size(path()) - 1);

  ReadingsLog log(folder());
  EXPECT_EQ(log.state().number(), 3);
  log.append(readings(4, 6));
  EXPECT_EQ(ReadingsReader(folder()).read_new().size(), 6u);
  const auto is_aside = [](const auto& entry) {
    return entry.path().filename().string().starts_with("readings.log.cut-");
  };
  EXPECT_EQ(std::ranges::count_if(std::filesystem::directory_iterator(folder()), is_aside), 1);
}

TEST_F(ReadingsLogTest, AWholeReadingBehindADamagedOneIsDamage) {
  ReadingsLog(folder()).append(readings(1, 30));
  const std::string sound = storage::read_file(path());
  for (const std::size_t byte : {sound.size() / 3, sound.size() / 2}) {
    std::string damaged = sound;
    damaged[byte] = static_cast<char>(damaged[byte] ^ 4);
    storage::write_file(path(), damaged);
    EXPECT_THROW(ReadingsReader(folder()).read_new(), DamagedReadings) << byte;
    EXPECT_THROW(ReadingsLog{folder()}, DamagedReadings) << byte;
    EXPECT_EQ(storage::read_file(path()), damaged) << "nothing is set aside";
  }
}

TEST_F(ReadingsLogTest, RefusesAReadingThatNoReaderWouldTake) {
  ReadingsLog log(folder());
  Readings last = readings(1, 1), too_long = readings(2, 2);
  last.Mutable(0)->add_curls()->set_monitor(std::string(longest_entry - 100, 'x'));
  too_long.Mutable(0)->add_curls()->set_monitor(std::string(longest_entry, 'x'));
  log.append(last);
  EXPECT_THROW(log.append(too_long), UnfitReading);
  log.append(readings(2, 3));
  EXPECT_EQ(ReadingsReader(folder()).read_new().size(), 3u);
}

TEST_F(ReadingsLogTest, WhatFitsARecordIsReadFromIt) {
  v1::Following largest = following();
  while (fits_record(largest)) largest.add_gauges()->set_monitor(std::string(100, 'x'));
  largest.mutable_gauges()->RemoveLast();

  std::filesystem::remove(path());
  create_readings_log(folder(), largest);
  EXPECT_EQ(ReadingsReader(folder()).following().gauges_size(), largest.gauges_size());
}

TEST_F(ReadingsLogTest, RefusesAFileThatIsNone) {
  storage::write_file(path(), "nothing of ours, but long enough");
  EXPECT_THROW(ReadingsReader{folder()}, DamagedReadings);
  EXPECT_THROW(ReadingsLog{folder()}, DamagedReadings);
}

TEST_F(ReadingsLogTest, RefusesReadingsThatGoBackInTime) {
  const auto add = [this](std::int64_t number, double time_s) {
    v1::RecordEntry entry;
    entry.mutable_reading()->set_number(number);
    entry.mutable_reading()->set_time_s(time_s);
    storage::RecordLog(storage::File(path(), O_RDWR))
        .append(storage::short_records.framed(entry.SerializeAsString()));
  };
  add(1, 5.0);
  EXPECT_EQ(ReadingsLog(folder()).state().time_s(), 5.0);
  add(2, 4.0);
  EXPECT_THROW(ReadingsLog{folder()}, DamagedReadings);
}

/// 10^6 readings 1e-7 s apart once made each look at the job take seconds.
TEST_F(ReadingsLogTest, RefusesReadingsThatLieTooClose) {
  ReadingsLog log(folder());
  log.append(readings(1, 1));
  Readings close = readings(2, 2);
  close.Mutable(0)->set_time_s(1.0 + 1e-7);
  EXPECT_THROW(log.append(close), UnfitReading);
  close.Mutable(0)->set_time_s(1.0 + 1.5 * least_spacing_s);
  log.append(close);
  EXPECT_EQ(log.state().number(), 2);
}

TEST_F(ReadingsLogTest, TakesSoManyAtOnceAndLaterMore) {
  ReadingsLog log(folder());
  constexpr std::int64_t batch = 1000;
  std::int64_t taken = 0;
  try {
    for (; taken <= most_readings; taken += batch) log.append(readings(taken + 1, taken + batch));
    FAIL() << "all were taken";
  } catch (const TooManyAtOnce&) {
    EXPECT_GE(taken, static_cast<std::int64_t>(readings_at_once));
    EXPECT_LT(taken, most_readings);
  }
  EXPECT_EQ(log.state().number(), taken) << "a call is taken as a whole or not at all";

  const auto is_taken = [&] {
    try {
      log.append(readings(taken + 1, taken + batch));
      return true;
    } catch (const TooManyAtOnce&) {
      return false;
    }
  };
  EXPECT_TRUE(eventually(is_taken, std::chrono::seconds(20)));
  EXPECT_EQ(log.state().number(), taken + batch);
}

TEST_F(ReadingsLogTest, IsFullAtItsBoundAndCanStillBeClosed) {
  write_records(most_readings);
  ReadingsLog log(folder());
  EXPECT_EQ(log.state().number(), most_readings);
  EXPECT_THROW(log.append(readings(most_readings + 1, most_readings + 1)), RecordFull);

  Readings last = readings(most_readings + 1, most_readings + 1);
  last.Mutable(0)->set_closes(true);
  log.append(last);
  EXPECT_TRUE(log.state().closed());
}

/// A worker that was taken over can write its own record.
TEST_F(ReadingsLogTest, ARecordBeyondItsBoundIsDamaged) {
  std::filesystem::resize_file(path(), longest_record + 1);
  EXPECT_THROW(ReadingsReader(folder()).read_new(), DamagedReadings);
  EXPECT_THROW(ReadingsLog{folder()}, DamagedReadings);
}

TEST_F(ReadingsLogTest, OpensEachFileOnce) {
  const std::filesystem::path jobs = folder().parent_path().parent_path();
  ReadingsLogs logs(jobs);
  const std::string id = folder().parent_path().filename();
  const auto log = logs.open(id);
  EXPECT_EQ(logs.open(id), log);
  logs.close(id);
  EXPECT_NE(logs.open(id), log);
  EXPECT_THROW(logs.open("no job"), std::system_error);
}

}  // namespace
}  // namespace dccast::jobs
