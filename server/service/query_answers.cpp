#include "server/service/query_answers.hpp"

#include <algorithm>

namespace dccast::service {

void QueryAnswers::keep(const std::string& key, QueryAnswer answer) {
  std::size_t bytes = 0;
  for (const auto& message : answer) bytes += message.SpaceUsedLong();
  if (bytes > most_bytes_ || find(key)) return;
  const std::lock_guard lock(mutex_);
  recent_.push_front({key, std::make_shared<const QueryAnswer>(std::move(answer)), bytes});
  bytes_ += bytes;
  while (bytes_ > most_bytes_) {
    bytes_ -= recent_.back().bytes;
    recent_.pop_back();
  }
}

std::shared_ptr<const QueryAnswer> QueryAnswers::find(const std::string& key) {
  const std::lock_guard lock(mutex_);
  const auto found = std::ranges::find(recent_, key, &Entry::key);
  if (found == recent_.end()) return nullptr;
  recent_.splice(recent_.begin(), recent_, found);
  return found->answer;
}

}  // namespace dccast::service
