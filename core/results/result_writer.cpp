#include "core/results/result_writer.hpp"

#include <fmt/format.h>

#include <stdexcept>
#include <utility>

#include "core/results/checkpoint_file.hpp"
#include "core/results/result_file_builder.hpp"
#include "core/results/xdmf.hpp"
#include "core/storage/file.hpp"

namespace dccast::results {

namespace fs = std::filesystem;

namespace {

/// Name of a file while it is being written.
fs::path unfinished(const fs::path& path) {
  fs::path name = path;
  return name += ".part";
}

}  // namespace

/// The records up to a step.
struct ResultWriter::Cut {
  std::int64_t size = 0;  ///< of the journal with these records [bytes]
  std::int64_t records = 0;
  bool begins_with_header = false;
  std::optional<double> last_frame_time;  ///< [s]
};

std::optional<ResultWriter::Cut> ResultWriter::find_cut(const fs::path& journal,
                                                        std::int64_t step) try {
  Cut cut;
  const bool is_journal = visit_journal(journal, [&](const Record& record) {
    if (cut.size == 0) cut.begins_with_header = record.kind == RecordKind::header;
    if (record.kind == RecordKind::frame) {
      const Frame frame = read_frame(record.content);
      if (frame.step > step) return false;
      cut.last_frame_time = frame.time;
    }
    ++cut.records;
    cut.size = record.end;
    return true;
  });
  return is_journal ? std::optional(cut) : std::nullopt;
} catch (const std::out_of_range&) {
  return std::nullopt;
}

ResultWriter::ResultWriter(RunFiles files, const RunHeader& header)
    : files_(std::move(files)), journal_(files_.journal) {
  append_record(RecordKind::header, to_sections(header));
  journal_.write();
}

ResultWriter::ResultWriter(RunFiles files, const Cut& cut, std::vector<StepReport> history)
    : files_(std::move(files)),
      journal_(files_.journal, cut.size),
      records_(cut.records),
      last_frame_time_(cut.last_frame_time),
      history_(std::move(history)) {}

ResumedWriter ResultWriter::resume(const RunFiles& files, std::vector<StepReport> history,
                                   std::int64_t records) {
  if (!fs::exists(files.journal)) return {nullptr, "the journal is missing"};
  const auto cut = find_cut(files.journal, history.empty() ? 0 : history.back().step);
  if (!cut || !cut->begins_with_header) return {nullptr, "the journal is damaged"};
  if (cut->records < records) return {nullptr, "the journal has lost a record"};

  return {std::unique_ptr<ResultWriter>(new ResultWriter(files, *cut, std::move(history))), ""};
}

ResultWriter::~ResultWriter() {
  try {
    background_.wait();
  } catch (const std::exception&) {
    // The run has ended without publishing, and its caller has the error.
  }

  builder_.reset();
  std::error_code ignored;
  fs::remove(unfinished(files_.results), ignored);
}

std::unique_ptr<ResultFileBuilder> ResultWriter::take_builder() {
  // If the builder throws it is destroyed, and the next one starts from the beginning.
  if (builder_) return std::move(builder_);
  return std::make_unique<ResultFileBuilder>(files_.journal, unfinished(files_.results));
}

void ResultWriter::follow() {
  auto result_file = take_builder();
  result_file->follow();
  builder_ = std::move(result_file);
}

void ResultWriter::finish(const RunSummary& summary, const MeasuredLevers& levers) {
  const auto result_file = take_builder();
  result_file->finish(summary, levers, history_);

  const std::string name = files_.results.filename().string();
  const fs::path sidecar = fs::path(files_.results).replace_extension(".xdmf");
  storage::write_file(unfinished(sidecar), format_xdmf(result_file->frames(), name),
                      storage::readable_by_all);
  const fs::path at_end =
      files_.results.parent_path() / (files_.results.stem().string() + "-end.xdmf");
  storage::write_file(unfinished(at_end), format_last_frame(result_file->frames(), name),
                      storage::readable_by_all);

  // The sidecars are published first: whenever results.h5 exists, they exist too.
  storage::publish({{unfinished(sidecar), sidecar},
                    {unfinished(at_end), at_end},
                    {unfinished(files_.results), files_.results}});
}

void ResultWriter::append_record(RecordKind kind, const Sections& content) {
  journal_.append(kind, content);
  ++records_;
}

void ResultWriter::append(const StepReport& report) {
  history_.push_back(report);
}

void ResultWriter::append(const Frame& frame) {
  if (const char* array = find_misfit(frame))  // a bug of the caller
    throw std::logic_error(fmt::format("Frame: {} does not fit its mesh", array));
  append_record(RecordKind::frame, to_sections(frame));
  last_frame_time_ = frame.time;
}

void ResultWriter::flush() {
  journal_.write();
  background_.post([this] { follow(); });
}

void ResultWriter::checkpoint(const fs::path& path, Sections content,
                              std::function<void()> sync_steps) {
  journal_.write();
  content.set_integer(journal_records, records_);
  background_.post([this, path, content = std::move(content), sync_steps = std::move(sync_steps)] {
    journal_.sync();
    if (sync_steps) sync_steps();
    write_checkpoint(path, content);
  });
}

void ResultWriter::wait() {
  background_.wait();
}

void ResultWriter::publish(const RunSummary& summary, const MeasuredLevers& levers) {
  journal_.write();
  background_.post([this, summary, levers] { finish(summary, levers); });
  background_.wait();
}

}  // namespace dccast::results
