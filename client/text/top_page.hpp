#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "dccast/v1/service.pb.h"

namespace dccast::client {

/// What `dccast top` shows at one moment.
struct TopView {
  /// Address of the server, and its report of itself and of its jobs.
  std::string server;
  v1::GetServerInfoResponse about{};
  std::vector<v1::Job> running{};
  std::vector<v1::Job> queued{};  ///< newest first; may be some of many
};

/// A page of at most so many columns and lines, each ended; with what does not fit left out.
/// @param lines    0: as many as there are
/// @param now_unix [s since 1970]
std::string top_page(const TopView& view, int columns, int lines, std::int64_t now_unix);

}  // namespace dccast::client
