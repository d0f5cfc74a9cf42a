#include <cmath>
#include <iostream>

#include "client/case_options.hpp"
#include "client/commands/commands.hpp"
#include "client/message_json.hpp"
#include "client/render/table.hpp"

namespace dccast::client::commands {
namespace {

struct Options {
  std::string id;
  std::vector<std::string> set;
  bool json = false;
};

v1::PredictStudyRequest request_of(const Options& options) {
  v1::PredictStudyRequest request;
  request.set_id(options.id);
  const auto values = changes_of(options.set);
  *request.mutable_values() = {values.begin(), values.end()};
  return request;
}

std::string millimetres(double metres) {
  return render::fixed(1e3 * metres, 3);
}

void print(const v1::Prediction& prediction) {
  render::Table table({"monitor", ">curl mm", ">+- mm", ">at s", ">cast mm"});
  for (const v1::CurlCurve& curve : prediction.curves()) {
    const int last = curve.time_s_size() - 1;
    if (last < 0 || !std::isfinite(curve.curl_m(last))) continue;
    table.add({curve.monitor(), millimetres(curve.curl_m(last)),
               millimetres(curve.uncertainty_m(last)), render::fixed(curve.time_s(last), 2),
               render::fixed(1e3 * curve.cast_length_m(last), 1)});
  }
  std::cout << table.text() << std::flush;
  std::cerr << "from " << prediction.runs() << " runs; leave-one-out error "
            << millimetres(prediction.cross_validated_error_m()) << " mm (root mean square)\n";
  if (prediction.next_run().empty()) return;
  std::cerr << "most informative next run:";
  for (const v1::CaseChange& change : prediction.next_run())
    std::cerr << " --set '" << change.key() << "=" << change.value() << "'";
  std::cerr << '\n';
}

ExitCode run(const Options& options, Program& program) {
  Connection connection = program.connect();
  const v1::Prediction prediction = connection.call(&Stub::PredictStudy, request_of(options));
  if (options.json)
    std::cout << to_json(prediction).dump() << std::endl;
  else
    print(prediction);
  return ExitCode::done;
}

}  // namespace

void add_predict(CLI::App& app, Program& program) {
  auto options = make_options<Options>();
  CLI::App* const command = subcommand(
      app, "predict",
      "The curl at values that a sweep has not run, from a response surface over its runs. It "
      "covers "
      "the range of the sweep and nothing outside; the +- is its own standard error, without "
      "the mesh error of the runs",
      "dccast predict STUDY --set 'schedule.casting_speed=53 mm/min' --set "
      "schedule.water_flow.scale=0.9");
  command->add_option("STUDY", options->id, "Id of a sweep")->required();
  command->add_option("--set", options->set,
                      "KEY=VALUE of a swept key; others keep the value of the case");
  command->add_flag("--json", options->json, "As JSON, in metres, with the curves against time");
  command->callback([options, &program] {
    program.action = [options, &program] { return run(*options, program); };
  });
}

}  // namespace dccast::client::commands
