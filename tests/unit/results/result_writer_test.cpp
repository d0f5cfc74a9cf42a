#include "core/results/result_writer.hpp"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>

#include <random>

#include "core/results/checkpoint_file.hpp"
#include "core/results/result_reader.hpp"
#include "core/storage/file.hpp"
#include "core/storage/storage_error.hpp"
#include "tests/unit/results/sample_run.hpp"

namespace dccast::results {
namespace {

using storage::read_file;
using storage::StorageError;

constexpr std::int64_t last_step = 400;
constexpr std::int64_t steps_per_frame = 7;
constexpr std::int64_t steps_per_checkpoint = 20;

std::vector<StepReport> sample_steps(std::int64_t last) {
  std::vector<StepReport> steps;
  for (std::int64_t step = 1; step <= last; ++step) steps.push_back(sample_step(step));
  return steps;
}

/// A run as casting makes it, from its checkpoint on if there is one. @return false: started over
bool run_sample(const TemporaryFolder& folder) {
  const RunFiles files{folder / "results.journal", folder / "results.h5"};

  // Resume from the checkpoint, if the journal still fits it.
  std::int64_t step = 0;
  std::unique_ptr<ResultWriter> writer;
  if (const auto checkpoint = read_checkpoint(folder / "checkpoint.bin"); checkpoint.content) {
    step = checkpoint.content->integer("step");
    writer = ResultWriter::resume(files, sample_steps(step),
                                  checkpoint.content->integer(journal_records))
                 .writer;
  }

  const bool resumed = writer != nullptr;
  if (!resumed) {
    step = 0;
    writer = std::make_unique<ResultWriter>(files, sample_header());
    writer->append(sample_frame(0, 3, 100));
  }

  while (step < last_step) {
    writer->append(sample_step(++step));
    if (step % steps_per_frame == 0) {
      writer->append(sample_frame(step, 3, 100 + static_cast<int>(step)));
      writer->flush();
    }
    if (step % steps_per_checkpoint == 0) {
      Sections content;
      content.set_integer("step", step);
      writer->checkpoint(folder / "checkpoint.bin", std::move(content));
    }
  }

  writer->publish({});
  return resumed;
}

/// Runs the sample in a process that is killed after `delay` microseconds.
/// @return whether it ended before
bool run_and_kill(const TemporaryFolder& folder, int delay) {
  const pid_t child = ::fork();
  if (child == 0) {
    run_sample(folder);
    ::_exit(0);
  }
  ::usleep(static_cast<useconds_t>(delay));  // the instant of the kill is what is tried
  ::kill(child, SIGKILL);
  int status = 0;
  ::waitpid(child, &status, 0);
  return WIFEXITED(status);
}

TEST(ResultWriter, RefusesAForeignJournal) {
  const TemporaryFolder folder;
  storage::write_file(folder / "j", "something else altogether");
  EXPECT_EQ(ResultWriter::resume({folder / "j", folder / "r.h5"}, sample_steps(1), 1).reason,
            "the journal is damaged");
}

TEST(ResultWriter, DropsWhatCameAfterTheCheckpoint) {
  const TemporaryFolder folder;
  const RunFiles files{folder / "j", folder / "r.h5"};
  {
    ResultWriter writer(files, sample_header());
    for (std::int64_t step = 1; step <= 5; ++step) {
      writer.append(sample_step(step));
      writer.append(sample_frame(step, 3, 2));
    }
    writer.flush();
  }
  auto resumed = ResultWriter::resume(files, sample_steps(3), 4);
  ASSERT_TRUE(resumed.writer) << resumed.reason;

  resumed.writer->publish({});
  const ResultReader reader(folder / "r.h5");
  EXPECT_EQ(reader.history().size(), 3u);
  EXPECT_EQ(reader.frames(), 3u);
  EXPECT_EQ(reader.frame(reader.frames() - 1).step, 3);
}

// The journal has lost the frame of the last step, which the results of an undisturbed run have.
TEST(ResultWriter, DoesNotResumeWithoutARecordTheCheckpointCounts) {
  const TemporaryFolder folder;
  const RunFiles files{folder / "j", folder / "r.h5"};
  std::uintmax_t before_the_frame = 0;
  {
    ResultWriter writer(files, sample_header());
    writer.append(sample_step(1));
    before_the_frame = std::filesystem::file_size(folder / "j");
    writer.append(sample_frame(1, 3, 2));
    writer.checkpoint(folder / "c", {});
    writer.wait();
  }
  const auto checkpoint = read_checkpoint(folder / "c");
  const std::int64_t records = checkpoint.content->integer(journal_records);

  EXPECT_EQ(records, 2);  // header, frame
  EXPECT_TRUE(ResultWriter::resume(files, sample_steps(1), records).writer);

  std::filesystem::resize_file(folder / "j", before_the_frame);
  EXPECT_EQ(ResultWriter::resume(files, sample_steps(1), records).reason,
            "the journal has lost a record");
}

TEST(ResultWriter, MakesTheResultFileWhileTheRunGoesOn) {
  const TemporaryFolder folder;
  {
    ResultWriter writer({folder / "j", folder / "r.h5"}, sample_header());
    std::uintmax_t size = 0;
    for (std::int64_t step = 1; step <= 3; ++step) {
      writer.append(sample_step(step));
      writer.append(sample_frame(step, 3, 2000));
      writer.flush();
      writer.wait();
      EXPECT_GT(std::filesystem::file_size(folder / "r.h5.part"), size);
      size = std::filesystem::file_size(folder / "r.h5.part");
    }
    EXPECT_FALSE(std::filesystem::exists(folder / "r.h5"));
  }
  EXPECT_FALSE(std::filesystem::exists(folder / "r.h5.part")) << "left without publishing";
  EXPECT_TRUE(std::filesystem::exists(folder / "j"));
}

TEST(ResultWriter, DoesNotPublishHalfAJournal) {
  const TemporaryFolder folder;
  ResultWriter writer({folder / "j", folder / "r.h5"}, sample_header());
  writer.append(sample_step(1));
  writer.append(sample_frame(1, 3, 2));
  writer.checkpoint(folder / "c", {});
  writer.wait();
  std::filesystem::resize_file(folder / "j", std::filesystem::file_size(folder / "j") - 1);
  writer.append(sample_step(2));
  EXPECT_THROW(writer.publish({}), StorageError);
  EXPECT_FALSE(std::filesystem::exists(folder / "r.h5"));
}

TEST(ResultWriter, DoesNotResumeWithoutAJournal) {
  const TemporaryFolder folder;
  EXPECT_EQ(ResultWriter::resume({folder / "none", folder / "r.h5"}, sample_steps(1), 1).reason,
            "the journal is missing");
}

TEST(ResultWriter, SyncsTheStepsBeforeItWritesACheckpoint) {
  const TemporaryFolder folder;
  ResultWriter writer({folder / "j", folder / "r.h5"}, sample_header());
  bool first = false;
  writer.checkpoint(folder / "c", {}, [&] { first = !std::filesystem::exists(folder / "c"); });
  writer.wait();
  EXPECT_TRUE(first);
  EXPECT_TRUE(std::filesystem::exists(folder / "c"));
  writer.checkpoint(folder / "d", {},
                    [] { throw StorageError(EROFS, "the log", "is not synced"); });
  EXPECT_THROW(writer.wait(), StorageError);
  EXPECT_FALSE(std::filesystem::exists(folder / "d"));
}

TEST(ResultWriter, KilledAndResumedGivesTheSameBytes) {
  const TemporaryFolder whole;
  run_sample(whole);
  const TemporaryFolder broken;
  std::mt19937 random(7);
  int kills = 0;

  // The longest life grows, so that the end, which is made in one go, is reached on any machine.
  while (!run_and_kill(broken, std::uniform_int_distribution(500, 20000 + 10000 * kills)(random)))
    ASSERT_LT(++kills, 500) << "the run makes no headway";
  EXPECT_GT(kills, 0);
  EXPECT_EQ(read_file(broken / "results.h5"), read_file(whole / "results.h5"));
  EXPECT_EQ(read_file(broken / "results.xdmf"), read_file(whole / "results.xdmf"));
  EXPECT_EQ(read_file(broken / "results-end.xdmf"), read_file(whole / "results-end.xdmf"));
  EXPECT_FALSE(std::filesystem::exists(broken / "results.h5.part"));
}

}  // namespace
}  // namespace dccast::results
