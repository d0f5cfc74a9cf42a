#include "client/model/answer.hpp"

#include <cmath>

#include "proto/case_file/quality.hpp"

namespace dccast::client {

std::optional<double> discretisation_error(const v1::Case& complete, double curl_m) {
  const auto relative = case_file::relative_discretisation_error(complete);
  if (!relative) return std::nullopt;
  return *relative * std::abs(curl_m);
}

}  // namespace dccast::client
