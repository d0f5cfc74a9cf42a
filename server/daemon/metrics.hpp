#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "server/jobs/tally.hpp"
#include "server/service/context.hpp"

namespace dccast::daemon {

/// What the metrics are collected from, each time they are asked for.
struct MetricSources {
  service::Context& context;
  const jobs::Tally& tally;
  std::filesystem::path data_directory;
  std::string certificate;  ///< PEM file of the server; empty: it has none
};

/// All metrics in the text format of Prometheus, version 0.0.4. docs/metrics.md lists them.
std::string metrics_text(const MetricSources& sources);

/// Serves them on http://ADDRESS/metrics to this machine.
class MetricsServer {
public:
  /// @param address  on loopback; port 0 takes a free one @throws std::runtime_error  another, or
  ///                 one that is taken
  MetricsServer(const std::string& address, MetricSources sources);
  ~MetricsServer();
  /// Host and port in use.
  const std::string& address() const { return address_; }

private:
  struct Listener;
  std::unique_ptr<Listener> listener_;
  std::string address_;
};

}  // namespace dccast::daemon
