#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tests/verification/program/run_request.hpp"

namespace dccast::verification {

/// A test by its name on the command line.
struct NamedTest {
  std::string name;
  std::string shows;
  std::string lasts;  ///< order of magnitude, one core
  std::function<Result(const RunRequest&)> run;
};

const std::vector<NamedTest>& named_tests();

/// The request with the step that the test would take filled in, so that equal runs look equal.
RunRequest completed(RunRequest request);

/// @throws std::invalid_argument  for a name that is none, or data the test cannot use
Result run_by_name(const RunRequest& request);

/// What the paper prints for an algorithm in a test: parameters of sections 4.3.1, 4.3.2 and 4.3.4.
mechanics::Options options_of(const RunRequest& request);

}  // namespace dccast::verification
