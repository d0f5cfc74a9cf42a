#include "server/worker/stored_frames.hpp"

#include <algorithm>
#include <cmath>

#include "core/casting/simulation.hpp"
#include "core/results/journal.hpp"
#include "core/results/result_reader.hpp"

namespace dccast::worker {

StoredFrames::StoredFrames(const std::filesystem::path& directory, bool running)
    : file_(directory / (running ? casting::journal_name : "results.h5")), running_(running) {
  if (running_)
    read_times_of_journal();
  else
    read_times_of_results();
}

std::size_t StoredFrames::nearest(double time) const {
  const auto closest = std::ranges::min_element(
      times_, {}, [&](double stored) { return std::abs(stored - time); });
  return std::size_t(closest - times_.begin());
}

void StoredFrames::visit(std::size_t first, std::size_t count, const Visitor& use) const {
  if (running_) return visit_journal(first, count, use);

  const results::ResultReader reader(file_);
  for (std::size_t i = first; i < first + count; ++i) use(reader.frame(i));
}

void StoredFrames::read_times_of_results() {
  const results::ResultReader reader(file_);
  header_ = reader.header();
  times_ = reader.frame_times();
}

void StoredFrames::read_times_of_journal() {
  if (!std::filesystem::exists(file_)) return;

  results::visit_journal(file_, [&](const results::Record& record) {
    if (record.kind == results::RecordKind::header) header_ = results::read_header(record.content);
    if (record.kind == results::RecordKind::frame)
      times_.push_back(record.content.reals("instant").at(0));
    return true;
  });
}

void StoredFrames::visit_journal(std::size_t first, std::size_t count, const Visitor& use) const {
  std::size_t index = 0;
  results::visit_journal(file_, [&](const results::Record& record) {
    if (record.kind != results::RecordKind::frame) return true;
    if (index >= first + count) return false;

    if (index >= first) use(results::read_frame(record.content));
    ++index;
    return true;
  });
}

}  // namespace dccast::worker
