#include "server/worker/stored_frames.hpp"

#include <algorithm>
#include <cmath>

#include "core/casting/simulation.hpp"
#include "core/results/journal.hpp"

namespace dccast::worker {

StoredFrames::StoredFrames(const std::filesystem::path& directory, bool running)
    : journal_(directory / casting::journal_name) {
  if (running) {
    read_times_of_journal();
    return;
  }

  results_.emplace(directory / "results.h5");
  header_ = results_->header();
  times_ = results_->frame_times();
}

std::size_t StoredFrames::nearest(double time) const {
  const auto closest =
      std::ranges::min_element(times_, {}, [&](double stored) { return std::abs(stored - time); });
  return std::size_t(closest - times_.begin());
}

void StoredFrames::visit(std::size_t first, std::size_t count, const Visitor& use) const {
  if (!results_) return visit_journal(first, count, use);
  for (std::size_t i = first; i < first + count; ++i) use(results_->frame(i));
}

void StoredFrames::read_times_of_journal() {
  if (!std::filesystem::exists(journal_)) return;

  results::visit_journal(journal_, [&](const results::Record& record) {
    if (record.kind == results::RecordKind::header) header_ = results::read_header(record.content);
    if (record.kind == results::RecordKind::frame)
      times_.push_back(record.content.reals("instant").at(0));
    return true;
  });
}

void StoredFrames::visit_journal(std::size_t first, std::size_t count, const Visitor& use) const {
  std::size_t index = 0;
  results::visit_journal(journal_, [&](const results::Record& record) {
    if (record.kind != results::RecordKind::frame) return true;
    if (index >= first + count) return false;

    if (index >= first) use(results::read_frame(record.content));
    ++index;
    return true;
  });
}

}  // namespace dccast::worker
