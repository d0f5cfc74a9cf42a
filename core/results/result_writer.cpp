#include "core/results/result_writer.hpp"

#include <stdexcept>
#include <utility>

#include "core/results/checkpoint_file.hpp"
#include "core/results/journal.hpp"
#include "core/results/result_file_builder.hpp"
#include "core/results/xdmf.hpp"
#include "core/storage/background.hpp"
#include "core/storage/file.hpp"

namespace dccast::results {

namespace fs = std::filesystem;

namespace {

/// Position at which a journal is truncated to continue after a step, and the records found up to
/// there.
struct Cut {
  std::int64_t size = 0;
  std::int64_t records = 0;
  bool begins_with_header = false;
};

/// @return  the cut; nothing when the file is no journal or a record lacks what its kind has
std::optional<Cut> find_cut(const fs::path& journal, std::int64_t step) try {
  Cut cut;
  const bool is_journal = visit_journal(journal, [&](const Record& record) {
    if (cut.size == 0) cut.begins_with_header = record.kind == RecordKind::header;
    if (record.kind == RecordKind::frame && frame_of(record.content).step > step) return false;
    ++cut.records;
    cut.size = record.end;
    return true;
  });
  return is_journal ? std::optional(cut) : std::nullopt;
} catch (const std::out_of_range&) {
  return std::nullopt;
}

fs::path unfinished(const fs::path& path) {
  fs::path name = path;
  return name += ".part";
}

}  // namespace

/// On the heap: the thread needs a fixed address.
struct ResultWriter::Parts {
  Parts(RunFiles of_run, Journal of_files)
      : files(std::move(of_run)), journal(std::move(of_files)) {}
  Parts(const Parts&) = delete;
  ~Parts();

  // Used by the thread.
  void follow();
  void finish(const RunSummary& summary);
  ResultFileBuilder take_builder();

  RunFiles files;
  Journal journal;
  std::int64_t records = 0;         ///< appended to the journal
  std::vector<StepReport> history;  ///< read by the thread in finish(), when no step follows
  std::optional<ResultFileBuilder> builder;  ///< the thread's
  storage::Background background;            ///< last: its thread ends before what it works with
};

ResultWriter::Parts::~Parts() {
  try {
    background.wait();
  } catch (const std::exception&) {
    // The run has ended without publishing; the caller knows why.
  }
  builder.reset();
  std::error_code ignored;
  fs::remove(unfinished(files.results), ignored);
}

ResultFileBuilder ResultWriter::Parts::take_builder() {
  // Where it throws it is lost, and the next one starts over.
  if (auto begun = std::exchange(builder, std::nullopt)) return std::move(*begun);
  return {files.journal, unfinished(files.results)};
}

void ResultWriter::Parts::follow() {
  ResultFileBuilder result_file = take_builder();
  result_file.follow();
  builder = std::move(result_file);
}

void ResultWriter::Parts::finish(const RunSummary& summary) {
  ResultFileBuilder result_file = take_builder();
  result_file.finish(summary, history);
  const fs::path sidecar = fs::path(files.results).replace_extension(".xdmf");
  storage::write_file(unfinished(sidecar),
                      xdmf_of(result_file.frames(), files.results.filename().string()),
                      storage::readable_by_all);
  // The sidecar is published first: whenever results.h5 exists, it exists too.
  storage::publish({{unfinished(sidecar), sidecar}, {unfinished(files.results), files.results}});
}

ResultWriter::ResultWriter(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}
ResultWriter::ResultWriter(ResultWriter&&) noexcept = default;
ResultWriter& ResultWriter::operator=(ResultWriter&&) noexcept = default;
ResultWriter::~ResultWriter() = default;

ResultWriter ResultWriter::create(const RunFiles& files, const RunHeader& header) {
  ResultWriter writer(std::make_unique<Parts>(files, Journal::create(files.journal)));
  writer.append_record(RecordKind::header, to_sections(header));
  writer.parts_->journal.write();
  return writer;
}

ResumedWriter ResultWriter::resume(const RunFiles& files, std::vector<StepReport> history,
                                   std::int64_t records) {
  if (!fs::exists(files.journal)) return {std::nullopt, "the journal is missing"};
  const auto cut = find_cut(files.journal, history.empty() ? 0 : history.back().step);
  if (!cut || !cut->begins_with_header) return {std::nullopt, "the journal is damaged"};
  if (cut->records < records) return {std::nullopt, "the journal has lost a record"};
  ResultWriter writer(std::make_unique<Parts>(files, Journal::reopen(files.journal, cut->size)));
  writer.parts_->records = cut->records;
  writer.parts_->history = std::move(history);
  return {std::move(writer), ""};
}

void ResultWriter::append_record(RecordKind kind, const Sections& content) {
  parts_->journal.append(kind, content);
  ++parts_->records;
}

void ResultWriter::append(const StepReport& report) {
  parts_->history.push_back(report);
}

void ResultWriter::append(const Frame& frame) {
  if (const char* array = misfit_of(frame))  // a bug of the caller
    throw std::logic_error(std::string("Frame: does not fit its mesh: ") + array);
  append_record(RecordKind::frame, to_sections(frame));
}

void ResultWriter::flush() {
  parts_->journal.write();
  parts_->background.post([parts = parts_.get()] { parts->follow(); });
}

void ResultWriter::checkpoint(const fs::path& path, Sections content,
                              std::function<void()> sync_steps) {
  parts_->journal.write();
  content.set_integer(journal_records, parts_->records);
  parts_->background.post([parts = parts_.get(), path, content = std::move(content),
                           sync_steps = std::move(sync_steps)] {
    parts->journal.sync();
    if (sync_steps) sync_steps();
    write_checkpoint(path, content);
  });
}

void ResultWriter::wait() {
  parts_->background.wait();
}

void ResultWriter::publish(const RunSummary& summary) {
  parts_->journal.write();
  parts_->background.post([parts = parts_.get(), summary] { parts->finish(summary); });
  parts_->background.wait();
}

void ResultWriter::remove_journal() {
  fs::remove(parts_->files.journal);
}

}  // namespace dccast::results
