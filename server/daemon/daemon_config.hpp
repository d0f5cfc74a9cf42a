#pragma once

#include <stdexcept>
#include <string>
#include <vector>

#include "dccast/v1/config.pb.h"

namespace dccast::daemon {

/// The settings are not usable; the text names every fault, one a line.
class InvalidConfig : public std::runtime_error {
public:
  using std::runtime_error::runtime_error;
};

/// Reads the settings: file, then overrides, then defaults, all by the schema of config.proto.
/// @param file       TOML; empty: none
/// @param overrides  "key=value" @throws InvalidConfig
v1::DaemonConfig read_config(const std::string& file, const std::vector<std::string>& overrides);

}  // namespace dccast::daemon
