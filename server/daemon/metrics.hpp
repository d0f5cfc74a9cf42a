#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "server/jobs/queue/tally.hpp"
#include "server/service/context.hpp"

namespace dccast::daemon {

/// What the metrics are collected from, each time they are asked for.
struct MetricSources {
  service::Context& context;
  const jobs::Tally& tally;
  std::filesystem::path data_directory;
  std::string certificate;   ///< PEM file of the server; empty: it has none
  bool shows_owners = true;  ///< false: users see only their own jobs, so no name is a label
};

/// Serves all metrics (docs/metrics.md) on http://ADDRESS/metrics to this machine, in the text
/// format of Prometheus, version 0.0.4, as long as the result lives.
/// @param address  on loopback; port 0 takes a free one @throws std::runtime_error  another, or one
///                 that is taken
std::shared_ptr<void> serve_metrics(const std::string& address, MetricSources sources);

}  // namespace dccast::daemon
