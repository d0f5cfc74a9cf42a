#include <fstream>
#include <iostream>

#include "client/cli/common_options.hpp"
#include "client/commands/commands.hpp"
#include "client/model/answer.hpp"
#include "client/model/measured_csv.hpp"
#include "client/session/case_faults.hpp"
#include "client/session/data_study.hpp"
#include "client/session/studies.hpp"
#include "proto/case_file/case_file.hpp"
#include "proto/case_file/quantity.hpp"

namespace dccast::client {
namespace {

constexpr int most_rounds = 3;  // of further runs

struct CalibrateOptions : StudyOptions {
  CalibrationPlan plan;
  std::vector<std::string> measured, castings, noise;
  std::string output;
};

/// A case file and the files with its measurements.
struct MeasuredCase {
  std::string file;
  std::vector<std::string> measured;
};

std::vector<MeasuredCase> cases_of(const CalibrateOptions& options) {
  std::vector<MeasuredCase> cases{{options.base.file, options.measured}};
  for (const std::string& text : options.castings) {
    const auto colon = text.rfind(':');
    if (colon == std::string::npos || colon == 0 || colon + 1 == text.size())
      throw invalid("--casting " + text + ": write CASE.toml:MEASURED.csv");
    cases.push_back({text.substr(0, colon), {text.substr(colon + 1)}});
  }
  return cases;
}

/// Standard deviations given by the user: "0.5 mm" for curls, "3 K" for temperatures; 0 if not
/// given.
struct Noise {
  double curl_m = 0.0, temperature_k = 0.0;
};

Noise noise_of(const std::vector<std::string>& texts) {
  Noise noise;
  for (const std::string& text : texts) {
    const auto metres = case_file::parse_quantity(text, "m").value;
    const auto kelvin = case_file::parse_quantity(text, "K").value;
    const auto value = metres ? metres : kelvin;
    if (!value || !(*value > 0.0))
      throw invalid("--noise \"" + text + "\": write a length or kelvins, as 0.5 mm or 3 K");
    (metres ? noise.curl_m : noise.temperature_k) = *value;
  }
  return noise;
}

/// The measured curves of one casting. Throws CommandFailed with all faults of its files.
std::vector<v1::MeasuredCurve> read_curves(const MeasuredCase& casting, const v1::Case& description,
                                           const Noise& noise) {
  std::vector<std::string> monitors;
  for (const v1::Monitor& monitor : description.monitor()) monitors.push_back(monitor.name());
  std::vector<v1::MeasuredCurve> curves;
  std::string faults;
  for (const std::string& file : casting.measured) {
    std::ifstream stream(file);
    if (!stream) throw invalid("cannot read " + file);
    MeasuredFile read = read_measured(stream, file, monitors);
    for (const std::string& fault : read.faults) faults += "\n  " + fault;
    // One noise for all curls and one for all temperatures; none leaves it to be inferred.
    for (v1::MeasuredCurve& curve : read.curves) {
      curve.set_noise(curve.curl_m_size() > 0 ? noise.curl_m : noise.temperature_k);
      curves.push_back(std::move(curve));
    }
  }
  if (!faults.empty()) throw invalid("measurements have faults:" + faults);
  return curves;
}

/// Creates the study of every casting. @return empty if a case has faults, which have been printed
std::vector<CastingStudies> create(Connection& connection, const CalibrateOptions& options) {
  if (options.measured.empty()) throw invalid("give the measurements, e.g. --measured curl.csv");
  const Noise noise = noise_of(options.noise);
  const auto cases = cases_of(options);

  std::vector<std::vector<v1::MeasuredCurve>> curves;  // all are read before any run is queued
  for (const MeasuredCase& casting : cases)
    curves.push_back(read_curves(
        casting, read_case(casting.file, changes_of(options.base.set)).description, noise));

  std::vector<CastingStudies> castings;
  google::protobuf::RepeatedPtrField<v1::SweepPlan::Axis> axes;
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const StudyCase base{cases[i].file, options.base.set, options.base.labels,
                         options.plan.free.empty() ? "" : "--free"};

    const auto study = create_study(connection, base, [&](v1::CreateStudyRequest& request) {
      CalibrationPlan plan = options.plan;
      plan.measured = curves[i];
      lay_out_calibration(plan, axes, request);
    });
    if (!study) return {};
    axes = study->sweep().axes();  // the same for every casting
    castings.push_back({study->id()});
    std::cerr << "study " << study->id() << ", " << study->runs() << " runs over "
              << study->sweep().axes_size() << " keys\n";
  }
  return castings;
}

std::vector<CastingStudies> castings_of(Connection& connection, const std::string& ids) {
  std::vector<CastingStudies> castings;
  for (std::size_t begin = 0; begin <= ids.size();) {
    const std::size_t end = std::min(ids.find(',', begin), ids.size());
    castings.push_back({resolve_study(connection, ids.substr(begin, end - begin))});
    begin = end + 1;
  }
  return castings;
}

std::string joined(const std::vector<CastingStudies>& castings) {
  std::string ids;
  for (const CastingStudies& casting : castings) ids += (ids.empty() ? "" : ",") + casting.front();
  return ids;
}

/// Computes runs at the calibrated values and along the ridge until they agree with the surface.
v1::StudyJudgement checked(Connection& connection, std::vector<CastingStudies>& castings,
                           const std::string& come_back) {
  v1::StudyJudgement answer = connection.call(&Stub::JudgeStudy, question_about(castings));
  const v1::SweepPlan plan = answer.study().sweep();
  for (int round = 1; round <= most_rounds && answer.result().has_calibration(); ++round) {
    std::cerr << "runs at the calibrated values and along the ridge, round " << round << " of "
              << most_rounds << " at most\n";
    const auto added = add_checks(connection, answer.result().calibration(), plan, castings);
    if (added.empty()) break;  // none of them counts: they failed

    for (const std::string& id : added) follow_with_progress(connection, id, come_back);
    answer = connection.call(&Stub::JudgeStudy, question_about(castings));
    if (std::ranges::all_of(answer.result().calibration().curves(),
                            &v1::Calibration::Curve::is_confirmed))
      break;
  }
  return answer;
}

void print(Connection& connection, const CalibrateOptions& options,
           const std::vector<CastingStudies>& castings, const v1::StudyJudgement& answer) {
  print_answer(options, answer, options.output);
  if (!options.output.empty() && answer.result().has_calibration())
    write_output(options.output, found_case(connection, question_about(castings), options.base));
}

void require_sense(const CalibrateOptions& options) {
  if (options.base.file.empty() && options.study.empty())
    throw invalid("give a case FILE to begin, or --study ID to take a calibration up again");
  if (!options.output.empty() && options.base.file.empty())
    throw invalid("-o needs the case FILE, whose values it changes");
  for (const std::string& file : {options.plot, options.output}) require_free(file, options.force);
}

ExitCode run(const CalibrateOptions& options, Program& program) {
  require_sense(options);
  Connection connection = program.connect();
  auto castings =
      options.study.empty() ? create(connection, options) : castings_of(connection, options.study);
  if (castings.empty()) return ExitCode::invalid;

  const std::string come_back = "dccast calibrate --study " + joined(castings);
  if (options.study.empty()) std::cerr << "taken up again by " << come_back << '\n';
  // A study that was just begun has nothing to show yet but its ids.
  if (options.no_wait && options.study.empty()) {
    std::cout << joined(castings) << std::endl;
    return ExitCode::done;
  }
  if (options.no_wait) {
    print(connection, options, castings,
          connection.call(&Stub::JudgeStudy, question_about(castings)));
    return ExitCode::done;
  }

  for (const CastingStudies& casting : castings)
    follow_with_progress(connection, casting.front(), come_back);
  const v1::StudyJudgement answer = checked(connection, castings, come_back);
  print(connection, options, castings, answer);
  return answer.result().has_calibration() ? ExitCode::done : ExitCode::solve_failed;
}

constexpr const char* calibrate_examples =
    R"(dccast calibrate my.toml --measured curl.csv --free alloy.coherency_solid_fraction=0.85..1 \
      --free 'cooling.bottom_block.wet_gap=2..5 mm' -o calibrated.toml --plot page.html
  dccast calibrate a.toml --measured a.csv --casting b.toml:b.csv     two castings, one answer
  dccast calibrate --study ID                     a calibration that was left

The file of measurements names its columns with their units: the time or the cast length, then
monitors of the case:
  time [s], curl corner [mm], thermocouple [degC]
  10,       4.1,              612
A length is a curl, a temperature that of the monitor. docs/calibration.md.)";

}  // namespace

void add_calibrate(CommandLine& line, Program& program) {
  const auto [command, options] =
      declare<CalibrateOptions>(line, program, run, "calibrate",
                                "Infer uncertain data from a measured curl or temperature: values, "
                                "ranges, and keys that the measurement cannot separate",
                                calibrate_examples);

  command.option("FILE", options.base.file, "Case file");
  command.repeatable("--measured", options.measured,
                     "CSV file of readings of this casting; repeatable");
  command.repeatable("--casting", options.castings,
                     "CASE.toml:MEASURED.csv of a further casting with the same data; repeatable");
  command.repeatable("--free", options.plan.free,
                     "KEY=RANGE, or KEY with the range of case or card; repeatable. Absent: every "
                     "key to which case or card gives a range");
  command.repeatable("--noise", options.noise,
                     "Standard deviation of a reading, as 0.5 mm or 3 K; absent: inferred");
  command.number("--runs", options.plan.data.runs, 8, 10000, "Runs of the Latin hypercube");
  command.option("--seed", options.plan.data.seed, "Its seed", shown);
  command.option(
      "-o,--output", options.output,
      "Write the case with the calibrated values and their ranges; - for standard output");

  add_study_options(command, options,
                    {.study = "Take this calibration up again; ids of several castings with commas",
                     .plot = "Write an HTML page with measured and computed curves and their "
                             "bands; - for standard output",
                     .json = "As JSON, in metres and degrees Celsius"});
}

}  // namespace dccast::client
