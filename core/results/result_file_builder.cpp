#include "core/results/result_file_builder.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "core/results/frame.hpp"
#include "core/results/hdf5_file.hpp"
#include "core/results/journal.hpp"
#include "core/results/result_reader.hpp"
#include "core/results/step_report.hpp"
#include "core/storage/storage_error.hpp"

namespace dccast::results {

namespace {

using hdf5::File;

constexpr double absent = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t coordinates = 3;
constexpr std::array severities{Severity::note, Severity::warning, Severity::danger};

struct TextField {
  const char* dataset;
  const char* meaning;
  std::string Finding::*member;
};
constexpr std::array texts{
    TextField{"/findings/code", "as in docs/findings.md", &Finding::code},
    TextField{"/findings/message", "what it means in practice", &Finding::message},
    TextField{"/findings/unit", "of value and limit", &Finding::unit},
    TextField{"/findings/key", "key of the case that sets the limit or causes the finding",
              &Finding::key},
};

struct RealField {
  const char* dataset;
  const char* unit;  ///< that of the finding where it is 1
  const char* meaning;
  std::optional<double> Finding::*member;
};
constexpr std::array reals{
    RealField{"/findings/time_s", "s", "when first found; NaN: follows from the case alone",
              &Finding::time},
    RealField{"/findings/value", "1", "in the unit of the finding", &Finding::value},
    RealField{"/findings/limit", "1", "in the unit of the finding", &Finding::limit},
};

/// A column of a text for each finding.
template <class TextOf>
std::vector<std::string> column(const std::vector<Finding>& findings, TextOf&& text_of) {
  std::vector<std::string> values;
  for (const Finding& finding : findings) values.emplace_back(text_of(finding));
  return values;
}

/// Places of the undeformed slab as rows of three coordinates.
void write_places(File& file, const char* dataset, const std::vector<std::vector<double>>& place,
                  const char* meaning) {
  std::vector<double> rows(place.size() * coordinates, absent);
  for (std::size_t i = 0; i < place.size(); ++i)
    std::copy_n(place[i].begin(), std::min(place[i].size(), coordinates),
                rows.begin() + static_cast<std::ptrdiff_t>(i * coordinates));
  file.write(dataset, {place.size(), coordinates}, rows, "m", meaning);
}

std::vector<std::vector<double>> read_places(const File& file, const char* dataset,
                                             std::size_t count) {
  const auto rows = file.read_reals(dataset, count * coordinates);
  std::vector<std::vector<double>> place(count);
  for (std::size_t i = 0; i < rows.size(); ++i)
    if (std::isfinite(rows[i])) place[i / coordinates].push_back(rows[i]);
  return place;
}

void write_worst(File& file, const std::vector<Finding>& findings) {
  std::vector<double> time, value;
  std::vector<std::vector<double>> place;
  for (const Finding& finding : findings) {
    const Exceedance worst = finding.worst.value_or(Exceedance{absent, absent, {}});
    time.push_back(worst.time);
    value.push_back(worst.value);
    place.push_back(worst.place);
  }
  file.write("/findings/worst_time_s", time, "s",
             "of the figure farthest beyond the limit; NaN if there is none");
  file.write("/findings/worst_value", value, "1", "in the unit of the finding");
  write_places(file, "/findings/worst_place_m", place, "as place_m");
}

/// Files of programs that did not know it have none.
void read_worst(const File& file, std::vector<Finding>& findings) {
  if (!file.has("/findings/worst_value")) return;
  const auto time = file.read_reals("/findings/worst_time_s", findings.size());
  const auto value = file.read_reals("/findings/worst_value", findings.size());
  const auto place = read_places(file, "/findings/worst_place_m", findings.size());
  for (std::size_t i = 0; i < findings.size(); ++i)
    if (std::isfinite(value[i])) findings[i].worst = Exceedance{time[i], value[i], place[i]};
}

Severity severity_named(const File& file, const std::string& name) {
  const auto found = std::ranges::find(severities, name, [](Severity s) { return name_of(s); });
  if (found == severities.end())
    throw storage::StorageError(EINVAL, file.path().string() + ":/findings/severity",
                                "names " + name);
  return *found;
}

}  // namespace

void write_findings(File& file, const std::vector<Finding>& findings) {
  if (findings.empty()) return;
  file.create_group("/findings");
  for (const TextField& field : texts)
    file.write_texts(field.dataset,
                     column(findings, [&](const Finding& f) { return f.*field.member; }),
                     field.meaning);
  file.write_texts("/findings/severity",
                   column(findings, [](const Finding& f) { return name_of(f.severity); }),
                   "note, warning or danger");
  for (const RealField& field : reals) {
    std::vector<double> values;
    for (const Finding& f : findings) values.push_back((f.*field.member).value_or(absent));
    file.write(field.dataset, values, field.unit, field.meaning);
  }
  std::vector<std::vector<double>> place;
  for (const Finding& finding : findings) place.push_back(finding.place);
  write_places(file, "/findings/place_m", place,
               "in the undeformed slab, in 2D two coordinates; NaN if there is no place");
  write_worst(file, findings);
}

std::vector<Finding> read_findings(const File& file) {
  if (!file.has("/findings")) return {};
  const auto severity = file.read_texts("/findings/severity");
  std::vector<Finding> findings(severity.size());
  for (std::size_t i = 0; i < findings.size(); ++i)
    findings[i].severity = severity_named(file, severity[i]);
  for (const TextField& field : texts) {
    const auto values = file.read_texts(field.dataset, findings.size());
    for (std::size_t i = 0; i < findings.size(); ++i) findings[i].*field.member = values[i];
  }
  for (const RealField& field : reals) {
    const auto values = file.read_reals(field.dataset, findings.size());
    for (std::size_t i = 0; i < findings.size(); ++i)
      if (std::isfinite(values[i])) findings[i].*field.member = values[i];
  }
  const auto place = read_places(file, "/findings/place_m", findings.size());
  for (std::size_t i = 0; i < findings.size(); ++i) findings[i].place = place[i];
  read_worst(file, findings);
  return findings;
}

// The layout is SCHEMA.md.

namespace {

using hdf5::File;
using hdf5::Shape;

using storage::StorageError;

void write_header(File& file, const RunHeader& header) {
  file.write_attribute("/", "schema_version", std::int64_t{schema_version});
  file.write_attribute("/", "program", std::string("dccast"));
  file.write_attribute("/", "program_version", header.program_version);
  file.write_attribute("/", "build", header.build);
  file.write_attribute("/", "title", header.title);
  file.write_attribute("/", "section", header.section);
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

/// Of a matrix with one row of components each, or of a vector.
Shape shape_of(std::size_t rows, int components) {
  if (components == 1) return {rows};
  return {rows, static_cast<hsize_t>(components)};
}

/// Arrays that a run does not compute are left out of the file.
void write_array(File& file, const std::string& group, const Frame& frame,
                 const FrameArray& array) {
  const std::vector<double>& values = frame.*array.values;
  if (!values.empty())
    file.write(group + "/" + array.dataset,
               shape_of(array.rows(frame), array.components(frame.dimension)), values, array.unit,
               array.meaning);
}

void write_frame(File& file, std::size_t index, const Frame& frame) {
  const std::string group = frame_group(index);
  file.create_group(group);
  file.write_attribute(group, "step", frame.step);
  file.write_attribute(group, "time_s", frame.time);
  file.write_attribute(group, "cast_length_m", frame.cast_length);
  file.write_attribute(group, "metal_level_m", frame.metal_level);
  file.write(group + "/node_m", shape_of(std::size_t(frame.nodes()), frame.dimension), frame.node,
             "m", "positions before deformation");
  file.write(group + "/element_node",
             shape_of(std::size_t(frame.elements()), frame.nodes_per_element), frame.element_node,
             "1", "nodes of each element, counter-clockwise, from 0");
  const auto is_of_bottom = [](const FrameArray& a) { return a.on == FrameArray::On::bottom; };
  for (const FrameArray& array : frame_arrays())
    if (!is_of_bottom(array)) write_array(file, group, frame, array);
  file.write(group + "/bottom_node", frame.bottom_node, "1",
             "nodes along the bottom, from the symmetry plane");
  for (const FrameArray& array : frame_arrays())
    if (is_of_bottom(array)) write_array(file, group, frame, array);
  for (const DerivedField& field : derived_fields(frame))
    file.write(group + "/" + field.name,
               shape_of(field.values.size() / std::size_t(field.components), field.components),
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
  if (displacement.size() != steps.size() * monitors * components)
    throw std::logic_error("StepReport: as many monitor displacements as monitors");
  file.write("/monitors/displacement_m", {steps.size(), monitors, components}, displacement, "m",
             "(step, monitor, coordinate)");
  if (temperature.size() == steps.size() * monitors)
    file.write("/monitors/temperature_c", {steps.size(), monitors}, temperature, "degC",
               "(step, monitor)");
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
        take(record);
        return true;
      },
      journal_end_);
  if (!is_journal) throw StorageError(EIO, journal_.string(), "is not the journal of a run");
}

void ResultFileBuilder::take(const Record& record) {
  if (record.kind == RecordKind::header) {
    const RunHeader header = header_of(record.content);
    monitors_ = header.monitor_name.size();
    dimension_ = header.dimension;
    write_header(file_, header);
  } else if (record.kind == RecordKind::frame) {
    const Frame frame = frame_of(record.content);
    write_frame(file_, frames_.size(), frame);
    frames_.push_back(outline_of(frame));
  }
  journal_end_ = record.end;
}

void ResultFileBuilder::finish(const RunSummary& summary, const std::vector<StepReport>& history) {
  follow();
  if (journal_end_ != static_cast<std::int64_t>(std::filesystem::file_size(journal_)))
    throw StorageError(EIO, journal_.string(), "is damaged");
  for (const HistoryField& field : history_fields()) {
    const auto write = field.real() ? write_field<double> : write_field<std::int64_t>;
    write(file_, field, history, dimension_);
  }
  write_monitors(file_, history, monitors_, dimension_);
  file_.write_attribute("/", "outcome", summary.outcome);
  file_.write_attribute("/", "message", summary.message);
  if (summary.validity_lost) write_validity_loss(file_, *summary.validity_lost);
  write_findings(file_, summary.findings);
  file_.write_attribute("/frames", "count", static_cast<std::int64_t>(frames_.size()));
  file_.close();
}

}  // namespace dccast::results
