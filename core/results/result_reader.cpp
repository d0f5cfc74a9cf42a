#include "core/results/result_reader.hpp"

#include <fmt/format.h>

#include <cerrno>

#include "core/results/findings_group.hpp"
#include "core/results/hdf5_file.hpp"

#include "core/results/step_report.hpp"
#include "core/storage/storage_error.hpp"

namespace dccast::results {

std::string frame_group(std::size_t index) {
  return fmt::format("/frames/{:06}", index);
}

namespace {

using hdf5::File;

/// Reads an array; empty if the run did not store it.
std::vector<double> read_optional_reals(const File& file, const std::string& object) {
  return file.has(object) ? file.read_reals(object) : std::vector<double>{};
}

std::vector<std::int32_t> narrow(const std::vector<std::int64_t>& values) {
  return {values.begin(), values.end()};
}

[[noreturn]] void throw_wrong_shape(const File& file, const std::string& object) {
  throw storage::StorageError(EINVAL, fmt::format("{}:{}", file.path().string(), object),
                              "has the wrong shape");
}

/// Number of columns of a matrix: coordinates of a point, or nodes of an element.
int read_columns(const File& file, const std::string& object) {
  constexpr hsize_t most = 8;
  const hdf5::Shape shape = file.shape_of(object);
  if (shape.size() != 2 || shape[1] == 0 || shape[1] > most) throw_wrong_shape(file, object);
  return static_cast<int>(shape[1]);
}

void read_field(const File& file, const HistoryField& field, std::vector<StepReport>& steps) {
  const int dimension = steps.empty() ? 2 : steps.front().dimension;
  const std::string object = history_dataset(field.name_in(dimension));
  if (field.real()) {
    const auto values = file.read_reals(object, steps.size());
    for (std::size_t i = 0; i < steps.size(); ++i) set_value(field, steps[i], values[i]);
  } else {
    const auto values = file.read_integers(object, steps.size());
    for (std::size_t i = 0; i < steps.size(); ++i) set_value(field, steps[i], values[i]);
  }
}

int read_dimension(const File& file) {
  return read_columns(file, "/monitors/position_m");
}

std::optional<ValidityLoss> read_validity_loss(const File& file) {
  const char* group = "/validity_loss";
  if (!file.has(group)) return std::nullopt;
  std::vector<double> place{file.real_attribute(group, "x_m"), file.real_attribute(group, "y_m")};
  if (read_dimension(file) == 3) place.push_back(file.real_attribute(group, "z_m"));
  return ValidityLoss{file.text_attribute(group, "kind"),   file.text_attribute(group, "message"),
                      file.real_attribute(group, "time_s"), place,
                      file.real_attribute(group, "value"),  file.real_attribute(group, "limit"),
                      file.text_attribute(group, "unit")};
}

}  // namespace

ResultReader::ResultReader(const std::filesystem::path& results)
    : file_(std::make_unique<File>(File::open(results))) {
  const auto version = file_->integer_attribute("/", "schema_version");
  if (version != schema_version)
    throw storage::StorageError(
        EINVAL, results.string(),
        fmt::format("has schema version {}, and this program reads {}: run the case again, or use "
                    "the version of dccast that wrote it",
                    version, schema_version));
  frames_ = static_cast<std::size_t>(file_->integer_attribute("/frames", "count"));
}

ResultReader::ResultReader(ResultReader&&) noexcept = default;
ResultReader::~ResultReader() = default;

RunHeader ResultReader::header() const {
  RunHeader header;
  header.program_version = file_->text_attribute("/", "program_version");
  header.build = file_->text_attribute("/", "build");
  header.commit = file_->text_attribute("/", "commit");
  header.case_sha256 = file_->text_attribute("/", "case_sha256");
  header.title = file_->text_attribute("/", "title");
  header.section = file_->text_attribute("/", "section");

  header.liquidus = file_->real_attribute("/", "liquidus_c");
  header.solidus = file_->real_attribute("/", "solidus_c");
  header.shell = file_->real_attribute("/", "shell_c");
  if (file_->has_attribute("/", "relative_curl_error"))
    header.relative_curl_error = file_->real_attribute("/", "relative_curl_error");

  const auto texts = file_->read_texts("/case");
  header.case_json = texts.empty() ? "" : texts.front();

  header.monitor_name = file_->read_texts("/monitors/name");
  header.dimension = read_dimension(*file_);
  const auto position = file_->read_reals(
      "/monitors/position_m", header.monitor_name.size() * std::size_t(header.dimension));
  header.monitor_position = split_points(position, header.monitor_name.size());
  return header;
}

RunSummary ResultReader::summary() const {
  return {file_->text_attribute("/", "outcome"),
          file_->text_attribute("/", "message"),
          read_validity_loss(*file_),
          read_findings(*file_),
          {}};
}

MeasuredLevers ResultReader::levers() const {
  return read_levers(*file_);
}

std::vector<StepReport> ResultReader::history() const {
  const char* object = "/monitors/displacement_m";
  const auto shape = file_->shape_of(object);
  const auto number = file_->read_integers(history_dataset("step"));
  if (shape.size() != 3 || shape[0] != number.size() || shape[2] < 2 || shape[2] > 3)
    throw_wrong_shape(*file_, object);

  std::vector<StepReport> steps(number.size());
  for (StepReport& step : steps) step.dimension = static_cast<int>(shape[2]);
  for (const HistoryField& field : history_fields()) read_field(*file_, field, steps);

  // (step, monitor, coordinate) in one list of points, all monitors of a step in a row.
  const auto flat_displacement = file_->read_reals(object);
  auto displacement = split_points(flat_displacement, flat_displacement.size() / shape[2]);
  const auto temperature = file_->read_reals("/monitors/temperature_c", displacement.size());

  for (std::size_t i = 0; i < displacement.size(); ++i) {
    StepReport& step = steps[i / shape[1]];
    step.monitor_displacement.push_back(std::move(displacement[i]));
    step.monitor_temperature.push_back(temperature[i]);
  }
  return steps;
}

std::vector<double> ResultReader::frame_times() const {
  std::vector<double> times;
  for (std::size_t i = 0; i < frames_; ++i)
    times.push_back(file_->real_attribute(frame_group(i), "time_s"));
  return times;
}

Frame ResultReader::frame(std::size_t index) const {
  const std::string group = frame_group(index);
  Frame frame;
  frame.step = file_->integer_attribute(group, "step");
  frame.time = file_->real_attribute(group, "time_s");
  frame.cast_length = file_->real_attribute(group, "cast_length_m");
  frame.metal_level = file_->real_attribute(group, "metal_level_m");

  frame.dimension = read_columns(*file_, group + "/node_m");
  frame.nodes_per_element = read_columns(*file_, group + "/element_node");
  frame.node = file_->read_reals(group + "/node_m");
  frame.element_node = narrow(file_->read_integers(group + "/element_node"));
  frame.bottom_node = narrow(file_->read_integers(group + "/bottom_node"));

  for (const FrameArray& array : frame_arrays())
    frame.*array.values = read_optional_reals(*file_, group + "/" + array.dataset);

  // A file may be damaged or written by another program.
  if (const char* array = find_misfit(frame))
    throw storage::StorageError(EINVAL, fmt::format("{}:{}", file_->path().string(), group),
                                fmt::format("{} does not fit its mesh", array));
  return frame;
}

}  // namespace dccast::results
