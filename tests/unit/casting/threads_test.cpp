// The results of a quarter slab do not depend on how many threads compute it.
#include <gtest/gtest.h>

#include <cstdint>

#include "core/casting/slab_run.hpp"
#include "core/mechanics/element_parts.hpp"
#include "core/results/result_reader.hpp"
#include "tests/unit/casting/small_quarter_slab.hpp"

namespace dccast::casting {
namespace {

using testing::equal_except_timing;
using testing::Recorder;

/// The small quarter slab with cells enough for threads to share every kind of work but the
/// solutions with large factors: contact, growth and solidification.
Case slab_to_share() {
  Case c = testing::small_quarter_slab();
  c.section.columns = 8;
  c.section.layers = 6;
  c.section.rows = 6;
  c.schedule.hold = 1.0;
  c.time.end = 1.5;
  c.output.frame_interval = 0.5;
  return c;
}

struct Whole {
  std::vector<results::StepReport> reports;
  std::vector<results::Frame> frames;
};

/// @param stop_after  step after which the run leaves at a checkpoint and goes on; none: -1
Whole whole_run(const Case& c, int threads, std::int64_t stop_after = -1) {
  const TemporaryFolder folder;
  Recorder recorder;
  if (stop_after >= 0) {
    recorder.act_after = stop_after;
    recorder.then = Order::stop_at_checkpoint;
    EXPECT_EQ(run(c, {folder / "", false}, recorder, threads).end, RunEnd::stopped);
    recorder.then = Order::go_on;
    recorder.before = recorder.reports;
    threads = 3 - threads;
  }
  const RunOutcome outcome = run(c, {folder / "", stop_after >= 0}, recorder, threads);
  EXPECT_EQ(outcome.end, RunEnd::succeeded) << in_words(outcome.failures);
  const results::ResultReader reader(folder / "results.h5");
  Whole found{recorder.reports, {}};
  for (std::size_t f = 0; f < reader.frame_times().size(); ++f)
    found.frames.push_back(reader.frame(f));
  return found;
}

void expect_same(const Whole& one, const Whole& other) {
  ASSERT_EQ(one.reports.size(), other.reports.size());
  for (std::size_t i = 0; i < one.reports.size(); ++i)
    ASSERT_TRUE(equal_except_timing(one.reports[i], other.reports[i])) << "step " << i + 1;
  ASSERT_EQ(one.frames.size(), other.frames.size());
  for (std::size_t f = 0; f < one.frames.size(); ++f)
    EXPECT_TRUE(one.frames[f] == other.frames[f]) << "frame " << f;
}

TEST(Threads, OneAndTwoGiveTheSameBits) {
  const Case c = slab_to_share();
  const Whole one = whole_run(c, 1);
  expect_same(whole_run(c, 2), one);
  EXPECT_GT(one.reports.back().nodes, one.reports.front().nodes) << "the slab has grown";
  int contact_changes = 0;
  for (const auto& report : one.reports) contact_changes += report.contact_changes;
  EXPECT_GT(contact_changes, 0);
  SlabRun<3> begun(c);
  EXPECT_GT(mechanics::ElementParts::of(begun.mesh()).parts(), 1u) << "there is work to share";
}

TEST(Threads, MayChangeInNumberWhereARunGoesOn) {
  const Case c = slab_to_share();
  const Whole one = whole_run(c, 1);
  expect_same(whole_run(c, 2, 4), one);
  expect_same(whole_run(c, 1, 7), one);
}

TEST(Threads, OfASectionAreOne) {
  const Case c = testing::small_casting(mesh::ElementKind::q1);
  const TemporaryFolder folder;
  Recorder recorder;
  ASSERT_EQ(run(c, {folder / "", false}, recorder, 2).end, RunEnd::succeeded);
  Recorder alone;
  const TemporaryFolder another;
  ASSERT_EQ(run(c, {another / "", false}, alone).end, RunEnd::succeeded);
  ASSERT_EQ(recorder.reports.size(), alone.reports.size());
  for (std::size_t i = 0; i < alone.reports.size(); ++i)
    EXPECT_TRUE(equal_except_timing(recorder.reports[i], alone.reports[i]));
}

}  // namespace
}  // namespace dccast::casting
