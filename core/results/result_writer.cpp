#include "core/results/result_writer.hpp"

#include <algorithm>
#include <stdexcept>

#include "core/results/xdmf.hpp"

namespace dccast::results {

namespace fs = std::filesystem;

namespace {

/// Where a journal is cut to go on after a step, and what was found on the way.
struct Cut {
  std::uint64_t size = 0;
  std::int64_t last_step = 0;
  bool begins_with_header = false;
};

/// @return  the cut; nothing when the file is no journal
std::optional<Cut> find_cut(const fs::path& journal, std::int64_t step) {
  Cut cut;
  const bool is_journal = visit_journal(journal, [&](const Record& record) {
    if (cut.size == 0) cut.begins_with_header = record.kind == RecordKind::header;
    std::int64_t number = 0;
    if (record.kind == RecordKind::step) number = step_of(record.content).step;
    if (record.kind == RecordKind::frame) number = frame_of(record.content).step;
    if (number > step) return false;
    cut.last_step = std::max(cut.last_step, number);
    cut.size = record.end;
    return true;
  });
  return is_journal ? std::optional(cut) : std::nullopt;
}

/// @throws std::logic_error  an array of the frame has not the size of its mesh: a bug of the
/// caller
void check_sizes(const Frame& frame) {
  const auto nodes = static_cast<std::size_t>(frame.nodes());
  const auto dimension = static_cast<std::size_t>(frame.dimension);
  const auto tensors =
      static_cast<std::size_t>(frame.elements() * tensor_components(frame.dimension));
  const auto require = [](bool fits, const char* array) {
    if (!fits) throw std::logic_error(std::string("Frame: size of ") + array);
  };
  const auto all_or_none = [](const std::vector<double>& values, std::size_t size) {
    return values.empty() || values.size() == size;
  };
  require(frame.node.size() == nodes * dimension, "node");
  require(frame.element_node.size() % static_cast<std::size_t>(frame.nodes_per_element) == 0,
          "element_node");
  require(all_or_none(frame.temperature, nodes), "temperature");
  require(all_or_none(frame.liquid_fraction, nodes), "liquid_fraction");
  require(all_or_none(frame.displacement, nodes * dimension), "displacement");
  require(all_or_none(frame.stress, tensors), "stress");
  require(all_or_none(frame.viscoplastic_strain, tensors), "viscoplastic_strain");
  require(all_or_none(frame.bottom_gap, frame.bottom_node.size()), "bottom_gap");
  require(all_or_none(frame.bottom_pressure, frame.bottom_node.size()), "bottom_pressure");
}

}  // namespace

ResultWriter ResultWriter::create(const fs::path& journal, const RunHeader& header) {
  ResultWriter writer(journal, Journal::create(journal));
  writer.journal_.append(RecordKind::header, to_sections(header));
  writer.flush();
  return writer;
}

ResumedWriter ResultWriter::resume(const fs::path& journal, std::int64_t step) {
  if (!fs::exists(journal)) return {std::nullopt, "the journal is missing"};
  const auto cut = find_cut(journal, step);
  if (!cut || !cut->begins_with_header) return {std::nullopt, "the journal is damaged"};
  if (cut->last_step < step) return {std::nullopt, "the journal ends before the checkpoint"};
  return {ResultWriter(journal, Journal::reopen(journal, cut->size)), ""};
}

void ResultWriter::append(const StepReport& report) {
  journal_.append(RecordKind::step, to_sections(report));
}

void ResultWriter::append(const Frame& frame) {
  check_sizes(frame);
  journal_.append(RecordKind::frame, to_sections(frame));
}

void ResultWriter::publish(const fs::path& results, const RunSummary& summary) {
  journal_.sync();
  fs::path unfinished = results;
  unfinished += ".part";
  write_result_file(journal_path_, unfinished, summary);
  // The sidecar comes first: whoever sees results.h5 finds it there.
  write_xdmf(fs::path(results).replace_extension(".xdmf"), unfinished, results.filename().string());
  results::publish(unfinished, results);
}

void ResultWriter::remove_journal() {
  fs::remove(journal_path_);
}

}  // namespace dccast::results
