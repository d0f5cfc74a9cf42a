#pragma once

#include <cstddef>
#include <list>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "dccast/v1/service.pb.h"

namespace dccast::service {

/// What a query was answered with, behind `accepted`.
using QueryAnswer = std::vector<v1::QueryButtCurlResponse>;

/// The answers of the last queries that succeeded and were not kept as jobs, by their answer_key().
/// Lost when the daemon ends. Safe to use from several threads.
class QueryAnswers {
public:
  /// @param most_bytes  of all answers together; the one asked for longest ago leaves first
  explicit QueryAnswers(std::size_t most_bytes = 64'000'000) : most_bytes_(most_bytes) {}

  void keep(const std::string& key, QueryAnswer answer);
  /// @return null when it is not there
  std::shared_ptr<const QueryAnswer> find(const std::string& key);

private:
  struct Entry {
    std::string key;
    std::shared_ptr<const QueryAnswer> answer;
    std::size_t bytes = 0;
  };

  const std::size_t most_bytes_;
  std::mutex mutex_;
  std::list<Entry> recent_;  ///< the one used last in front
  std::size_t bytes_ = 0;
};

}  // namespace dccast::service
