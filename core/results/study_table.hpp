#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace dccast::results {

/// Results of all runs of a study. Matrices are flat with the last index fastest.
struct StudyTable {
  /// Version that made the table.
  std::string program_version;
  std::string study;  ///< UUID
  std::string title;
  std::string state;  ///< of the study, "succeeded" and the like

  std::vector<std::string> key;      ///< (axis) of a sweep; empty for other studies
  std::vector<std::string> monitor;  ///< (monitor) names

  std::vector<std::string> job;        ///< (run) UUID; empty while a run has none
  std::vector<std::string> run_state;  ///< (run)
  std::vector<std::string> value;      ///< (run, axis) as written in the sweep
  std::vector<double> number;          ///< (run, axis) [SI unit of the key]; NaN if not a number
  std::vector<double> end_curl;        ///< (run, monitor) [m]; NaN if unknown
  std::vector<double> relative_curl_error;    ///< (run) [1] of mesh and time steps; NaN if unknown
  std::vector<double> solver_seconds;         ///< (run) [s]
  std::vector<std::int32_t> refinement;       ///< (run) for a refinement study; else 0
  std::vector<std::int32_t> beyond_validity;  ///< (run) 1: its curl is not valid
  std::vector<std::string> failure;           ///< (run) empty if there is none

  /// Index of the first sample of each run, followed by the number of samples.
  std::vector<std::int64_t> curve_start;  ///< (run + 1)
  std::vector<double> time;               ///< (sample) [s]
  std::vector<double> cast_length;        ///< (sample) [m]
  std::vector<double> curl;               ///< (sample, monitor) [m]; NaN if unknown

  std::vector<std::int32_t> finding_run;  ///< (finding) number of the run, from 0
  std::vector<std::string> finding_code, finding_severity;
  std::vector<double> finding_time;  ///< (finding) [s]; NaN if it follows from the case alone

  /// Number of runs, with and without a job.
  std::size_t runs() const { return job.size(); }
};

/// Writes the table in the format of docs/studies.md. Equal tables give identical files.
/// @throws StorageError
void write_study_table(const std::filesystem::path& path, const StudyTable& table);

}  // namespace dccast::results
