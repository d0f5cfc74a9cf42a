#include "core/results/study_table.hpp"

#include "core/results/hdf5_file.hpp"

namespace dccast::results {

namespace {

using hdf5::File;

constexpr std::int64_t table_schema_version = 1;

void write_root(File& file, const StudyTable& table) {
  file.write_attribute("/", "schema_version", table_schema_version);
  file.write_attribute("/", "program", std::string("dccast"));
  file.write_attribute("/", "program_version", table.program_version);

  file.write_attribute("/", "study", table.study);
  file.write_attribute("/", "title", table.title);
  file.write_attribute("/", "state", table.state);

  file.write_texts("/key", table.key, "keys of the case that the sweep changes");
  file.write_texts("/monitor", table.monitor, "names of the monitors");
}

void write_runs(File& file, const StudyTable& table) {
  const hdf5::Shape by_key{table.runs(), table.key.size()};
  const hdf5::Shape by_monitor{table.runs(), table.monitor.size()};

  file.create_group("/runs");
  file.write_texts("/runs/job", table.job, "UUID of the job of each run");
  file.write_texts("/runs/state", table.run_state, "state of each run");
  file.write_texts("/runs/value", by_key, table.value, "value of each key, as written");
  file.write("/runs/number", by_key, table.number, "SI", "the same as numbers");

  file.write("/runs/end_curl_m", by_monitor, table.end_curl, "m", "curl at the end");
  file.write("/runs/relative_curl_error", table.relative_curl_error, "1",
             "discretisation error of a curl, relative to the curl");
  file.write("/runs/solver_s", table.solver_seconds, "s", "processor time of the solver");
  file.write("/runs/refinement", table.refinement, "1", "of a refinement study");

  file.write("/runs/beyond_validity", table.beyond_validity, "1",
             "1: beyond validity, the curl is not valid");
  file.write_texts("/runs/failure", table.failure, "why a run failed");
}

void write_curves(File& file, const StudyTable& table) {
  file.create_group("/curves");
  file.write("/curves/start", table.curve_start, "1",
             "first sample of each run, and the number of samples");
  file.write("/curves/time_s", table.time, "s", "of each sample");
  file.write("/curves/cast_length_m", table.cast_length, "m", "of each sample");
  file.write("/curves/curl_m", {table.time.size(), table.monitor.size()}, table.curl, "m",
             "curl of each monitor");
}

void write_findings(File& file, const StudyTable& table) {
  file.create_group("/findings");
  file.write("/findings/run", table.finding_run, "1", "number of its run, from 0");
  file.write_texts("/findings/code", table.finding_code, "docs/findings.md");
  file.write_texts("/findings/severity", table.finding_severity, "note, warning or danger");
  file.write("/findings/time_s", table.finding_time, "s", "when first seen");
}

}  // namespace

void write_study_table(const std::filesystem::path& path, const StudyTable& table) {
  File file = File::create(path);
  write_root(file, table);
  write_runs(file, table);
  write_curves(file, table);
  write_findings(file, table);
  file.close();
}

}  // namespace dccast::results
