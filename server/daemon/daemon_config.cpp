#include "server/daemon/daemon_config.hpp"

#include <unistd.h>

#include <array>
#include <charconv>

#include "proto/case_file/case_file.hpp"

namespace dccast::daemon {

namespace {

constexpr std::array log_levels{"trace", "debug", "info", "warn", "error"};

std::string text_of(const v1::Fault& fault) {
  std::string text =
      fault.field() + (fault.value().empty() ? "" : " = " + fault.value()) + ": " + fault.message();
  if (!fault.permitted().empty()) text += "; permitted: " + fault.permitted();
  if (!fault.remedy().empty()) text += "; " + fault.remedy();
  return text;
}

void add(const std::vector<v1::Fault>& faults, const std::string& where, std::string& text) {
  for (const v1::Fault& fault : faults) text += where + ": " + text_of(fault) + "\n";
}

/// One "key=value" as a line of TOML. On a command line quotes are a nuisance: what is no TOML
/// value by itself is taken as text.
void override_key(const std::string& override_text, v1::DaemonConfig& config, std::string& faults) {
  const std::string where = "--set " + override_text;
  const auto equals = override_text.find('=');
  if (equals == std::string::npos) {
    faults += where + ": write it as key=value\n";
    return;
  }
  const std::string key = override_text.substr(0, equals);
  const std::string value = override_text.substr(equals + 1);
  v1::DaemonConfig one;
  auto outcome = case_file::read_text(key + " = " + value, where, one);
  if (!outcome.ok()) {
    one.Clear();
    const auto quoted = case_file::read_text(key + " = '" + value + "'", where, one);
    if (!quoted.ok()) return add(quoted.faults, where, faults);
  }
  config.MergeFrom(one);
}

/// gRPC and the system take a port modulo 65536.
void check_listen(const std::string& key, const std::string& listen, std::string& faults) {
  const auto colon = listen.rfind(':');
  if (colon == std::string::npos) {
    faults += key + " = " + listen + ": permitted: host:port, e.g. 127.0.0.1:7117\n";
    return;
  }
  unsigned port = 0;
  const char* end = listen.data() + listen.size();
  const auto [rest, error] = std::from_chars(listen.data() + colon + 1, end, port);
  if (error == std::errc() && rest == end && port <= 65535) return;
  faults += key + " = " + listen + ": the port is out of range; permitted: 0 to 65535; 0 takes a " +
            "free one, see port_file\n";
}

}  // namespace

v1::DaemonConfig read_config(const std::string& file, const std::vector<std::string>& overrides) {
  v1::DaemonConfig config;
  std::string faults;
  if (!file.empty()) add(case_file::read_file(file, config).faults, file, faults);
  for (const std::string& text : overrides) override_key(text, config, faults);
  case_file::apply_defaults(config);
  if (faults.empty()) add(case_file::check_ranges(config), "settings", faults);
  bool known_level = false;
  for (const char* level : log_levels) known_level = known_level || config.log_level() == level;
  if (!known_level)
    faults +=
        "log_level = " + config.log_level() + ": permitted: trace, debug, info, warn, error\n";
  check_listen("listen", config.listen(), faults);
  if (!config.metrics().empty()) check_listen("metrics", config.metrics(), faults);
  if (const std::string& hook = config.job_end_hook();
      !hook.empty() && (hook.front() != '/' || ::access(hook.c_str(), X_OK) != 0))
    faults += "job_end_hook = " + hook + ": permitted: the absolute path of a program\n";
  if (!config.listen_tls().empty()) check_listen("listen_tls", config.listen_tls(), faults);
  if (!faults.empty()) throw InvalidConfig(faults.substr(0, faults.size() - 1));
  return config;
}

}  // namespace dccast::daemon
