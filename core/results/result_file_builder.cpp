#include "core/results/result_file_builder.hpp"

#include <cerrno>
#include <stdexcept>
#include <utility>

#include "core/results/findings_group.hpp"
#include "core/results/frame.hpp"
#include "core/results/hdf5_file.hpp"
#include "core/results/journal.hpp"
#include "core/results/result_reader.hpp"
#include "core/results/step_report.hpp"
#include "core/storage/storage_error.hpp"

// The layout is SCHEMA.md.
namespace dccast::results {

namespace {

using hdf5::File;
using hdf5::Shape;
using storage::StorageError;

void write_header(File& file, const RunHeader& header) {
  file.write_attribute("/", "schema_version", std::int64_t{schema_version});
  file.write_attribute("/", "program", std::string("dccast"));
  file.write_attribute("/", "program_version", header.program_version);
  file.write_attribute("/", "build", header.build);
  file.write_attribute("/", "commit", header.commit);
  file.write_attribute("/", "title", header.title);
  file.write_attribute("/", "case_sha256", header.case_sha256);
  file.write_attribute("/", "section", header.section);

  // Temperatures of the isotherms that readers draw.
  file.write_attribute("/", "liquidus_c", header.liquidus);
  file.write_attribute("/", "solidus_c", header.solidus);
  file.write_attribute("/", "shell_c", header.shell);
  if (header.relative_curl_error)
    file.write_attribute("/", "relative_curl_error", *header.relative_curl_error);

  file.write_texts("/case", Shape{}, {header.case_json}, "the case as it was submitted, JSON");

  file.create_group("/frames");
  file.create_group("/history");
  file.create_group("/monitors");

  file.write_texts("/monitors/name", header.monitor_name, "names of the monitors");
  file.write("/monitors/position_m",
             {header.monitor_position.size(), static_cast<hsize_t>(header.dimension)},
             flat(header.monitor_position), "m",
             "first position: from the symmetry planes, above the bottom block");
}

/// Shape of an array with one row per node or element: a matrix, or a vector of one component each.
Shape row_shape(std::size_t rows, int components) {
  if (components == 1) return {rows};
  return {rows, static_cast<hsize_t>(components)};
}

/// Writes an array of a frame, if the run computes it.
void write_array(File& file, const std::string& group, const Frame& frame,
                 const FrameArray& array) {
  const std::vector<double>& values = frame.*array.values;
  if (!values.empty())
    file.write(group + "/" + array.dataset,
               row_shape(array.rows(frame), array.components(frame.dimension)), values, array.unit,
               array.meaning);
}

void write_frame(File& file, std::size_t index, const Frame& frame) {
  const std::string group = frame_group(index);
  file.create_group(group);
  file.write_attribute(group, "step", frame.step);
  file.write_attribute(group, "time_s", frame.time);
  file.write_attribute(group, "cast_length_m", frame.cast_length);
  file.write_attribute(group, "metal_level_m", frame.metal_level);

  file.write(group + "/node_m", row_shape(std::size_t(frame.nodes()), frame.dimension), frame.node,
             "m", "positions before deformation");
  file.write(group + "/element_node",
             row_shape(std::size_t(frame.elements()), frame.nodes_per_element), frame.element_node,
             "1", "nodes of each element, counter-clockwise, from 0");

  // Arrays along the bottom follow the list of its nodes.
  const auto on_bottom = [](const FrameArray& a) { return a.on == FrameArray::On::bottom; };
  for (const FrameArray& array : frame_arrays())
    if (!on_bottom(array)) write_array(file, group, frame, array);

  file.write(group + "/bottom_node", frame.bottom_node, "1",
             "nodes along the bottom, from the symmetry plane");
  for (const FrameArray& array : frame_arrays())
    if (on_bottom(array)) write_array(file, group, frame, array);

  for (const DerivedField& field : derived_fields(frame))
    file.write(group + "/" + field.name,
               row_shape(field.values.size() / std::size_t(field.components), field.components),
               field.values, field.unit, field.meaning);
}

template <class Number>
void write_field(File& file, const HistoryField& field, const std::vector<StepReport>& steps,
                 int dimension) {
  std::vector<Number> values;
  for (const StepReport& step : steps) values.push_back(value_of<Number>(field, step));
  file.write(history_dataset(field.name_in(dimension)), values, field.unit_in(dimension),
             field.meaning);
}

void write_monitors(File& file, const std::vector<StepReport>& steps, std::size_t monitors,
                    int dimension) {
  std::vector<double> displacement, temperature;
  for (const StepReport& step : steps) {
    const auto points = flat(step.monitor_displacement);
    displacement.insert(displacement.end(), points.begin(), points.end());
    temperature.insert(temperature.end(), step.monitor_temperature.begin(),
                       step.monitor_temperature.end());
  }

  const auto components = static_cast<hsize_t>(dimension);
  if (displacement.size() != steps.size() * monitors * components ||
      temperature.size() != steps.size() * monitors)
    throw std::logic_error("StepReport: as many displacements and temperatures as monitors");
  file.write("/monitors/displacement_m", {steps.size(), monitors, components}, displacement, "m",
             "(step, monitor, coordinate)");
  file.write("/monitors/temperature_c", {steps.size(), monitors}, temperature, "degC",
             "(step, monitor)");
}

/// Ties what was computed in each step to its time, and what belongs to a monitor to its name.
void attach_scales(File& file, int dimension) {
  const std::string time = history_dataset("time_s"), name = "/monitors/name";
  for (const HistoryField& field : history_fields())
    if (history_dataset(field.name_in(dimension)) != time)
      file.attach_scale(time, history_dataset(field.name_in(dimension)), 0);

  file.attach_scale(name, "/monitors/position_m", 0);
  for (const char* const of_steps : {"/monitors/displacement_m", "/monitors/temperature_c"}) {
    file.attach_scale(time, of_steps, 0);
    file.attach_scale(name, of_steps, 1);
  }
}

void write_validity_loss(File& file, const ValidityLoss& loss) {
  const char* group = "/validity_loss";
  file.create_group(group);
  file.write_attribute(group, "kind", loss.kind);
  file.write_attribute(group, "message", loss.message);
  file.write_attribute(group, "time_s", loss.time);
  file.write_attribute(group, "x_m", loss.place.at(0));
  file.write_attribute(group, "y_m", loss.place.at(1));
  if (loss.place.size() > 2) file.write_attribute(group, "z_m", loss.place[2]);
  file.write_attribute(group, "value", loss.value);
  file.write_attribute(group, "limit", loss.limit);
  file.write_attribute(group, "unit", loss.unit);
}

}  // namespace

ResultFileBuilder::ResultFileBuilder(std::filesystem::path journal,
                                     const std::filesystem::path& results)
    : journal_(std::move(journal)), file_(File::create(results)) {}

void ResultFileBuilder::follow() {
  const bool is_journal = visit_journal(
      journal_,
      [this](const Record& record) {
        add(record);
        return true;
      },
      journal_end_);
  if (!is_journal) throw StorageError(EIO, journal_.string(), "is not the journal of a run");
}

void ResultFileBuilder::add(const Record& record) {
  if (record.kind == RecordKind::header) {
    const RunHeader header = read_header(record.content);
    monitors_ = header.monitor_name.size();
    dimension_ = header.dimension;
    write_header(file_, header);
  } else if (record.kind == RecordKind::frame) {
    const Frame frame = read_frame(record.content);
    write_frame(file_, frames_.size(), frame);
    frames_.push_back(make_outline(frame));
  }
  journal_end_ = record.end;
}

void ResultFileBuilder::finish(const RunSummary& summary, const MeasuredLevers& levers,
                               const std::vector<StepReport>& history) {
  // The journal must end with a whole record: a cut one means that steps are lost.
  follow();
  if (journal_end_ != static_cast<std::int64_t>(std::filesystem::file_size(journal_)))
    throw StorageError(EIO, journal_.string(), "is damaged");

  for (const HistoryField& field : history_fields()) {
    const auto write = field.real() ? write_field<double> : write_field<std::int64_t>;
    write(file_, field, history, dimension_);
  }
  write_monitors(file_, history, monitors_, dimension_);
  attach_scales(file_, dimension_);

  // The outcome, and what led to it.
  file_.write_attribute("/", "outcome", summary.outcome);
  file_.write_attribute("/", "message", summary.message);
  if (summary.validity_lost) write_validity_loss(file_, *summary.validity_lost);
  write_findings(file_, summary.findings);
  write_margins(file_, summary.margins);
  write_levers(file_, levers);
  file_.write_attribute("/frames", "count", static_cast<std::int64_t>(frames_.size()));
  file_.close();
}

}  // namespace dccast::results
