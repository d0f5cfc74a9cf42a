#include "tests/verification/program/casting_history.hpp"

#include <cstdio>
#include <fstream>
#include <map>

#include "dccast/v1/case.pb.h"
#include "tests/support/load_case.hpp"
#include "tests/verification/program/casting_run.hpp"

namespace dccast::verification {

namespace {

const std::map<std::string, v1::Quality> qualities{
    {"draft", v1::DRAFT}, {"engineering", v1::ENGINEERING}, {"fine", v1::FINE}};

casting::Case case_of(const HistoryRequest& request) {
  casting::Case c = request.quality.empty()
                        ? shipped_casting(request.element)
                        : support::load_case(casting_name, qualities.at(request.quality));
  mesh::SectionSpec& s = c.section;
  s.element = request.element;
  if (request.columns) s.columns = *request.columns, s.side_cell = s.half_width / s.columns;
  if (request.rows) s.rows = *request.rows, s.bottom_cell = s.initial_depth / s.rows;
  if (request.growth_cell) s.growth_cell = request.growth_cell;
  s.refinement = request.refinement;
  std::vector<double> step = c.time.step.value();
  for (double& dt : step) dt /= request.divide_steps;
  c.time.step = Curve(c.time.step.abscissa(), c.time.step.at(), step);
  return c;
}

}  // namespace

void HistoryRequest::add_to(CLI::App& command) {
  command.add_option("--quality", quality, "draft, engineering or fine; absent: the paper's size")
      ->check(CLI::IsMember({"draft", "engineering", "fine"}));
  command.add_option("--columns", columns, "of equal width")->check(CLI::PositiveNumber);
  command.add_option("--rows", rows, "of equal height")->check(CLI::PositiveNumber);
  command.add_option("--growth-cell", growth_cell, "height of the rows that growth adds [m]")
      ->check(CLI::PositiveNumber);
  command.add_option("--refinement", refinement, "every cell divided")->check(CLI::PositiveNumber);
  command.add_option("--divide-steps", divide_steps, "every step divided")
      ->check(CLI::PositiveNumber);
  command.add_option("--limit", limit, "give it up after so many seconds");
  command.add_option("-o,--output", file, "CSV of the curl against time");
}

bool write_history(const HistoryRequest& request) {
  const CastingRun run = run_casting(case_of(request), request.limit);
  std::printf("nodes %lld, steps %zu, cpu %.3f s, curl %.4f mm, %s\n",
              static_cast<long long>(run.last.nodes), run.time_s.size(), run.seconds,
              run.curl_mm().value_or(0.0), run.ending().c_str());
  if (!request.file.empty()) {
    std::ofstream out(request.file);
    out.precision(10);
    out << "time_s,curl_mm\n";
    for (std::size_t i = 0; i < run.time_s.size(); ++i)
      out << run.time_s[i] << ',' << 1e3 * run.curl_m[i] << '\n';
  }
  return run.outcome.end == casting::RunEnd::succeeded;
}

}  // namespace dccast::verification
