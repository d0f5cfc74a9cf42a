#include "server/jobs/queue/dependents.hpp"

namespace dccast::jobs {

bool Dependents::add(const v1::Job& job) {
  if (job.after().empty()) return false;

  waiting_[job.id()] = {job.id(), {job.after().begin(), job.after().end()}, job.after_end()};
  for (const std::string& before : job.after()) awaited_by_[before].insert(job.id());
  to_check_.insert(job.id());
  return true;
}

void Dependents::remove(const std::string& id) {
  const auto found = waiting_.find(id);
  if (found == waiting_.end()) return;

  for (const std::string& before : found->second.before) {
    const auto awaited = awaited_by_.find(before);
    if (awaited == awaited_by_.end()) continue;  // named twice
    awaited->second.erase(id);
    if (awaited->second.empty()) awaited_by_.erase(awaited);
  }
  waiting_.erase(found);
  to_check_.erase(id);
}

void Dependents::note_change(const std::string& id) {
  if (const auto found = awaited_by_.find(id); found != awaited_by_.end())
    to_check_.insert(found->second.begin(), found->second.end());
}

std::optional<Dependents::Dependent> Dependents::take_next() {
  if (to_check_.empty()) return std::nullopt;

  const std::string id = *to_check_.begin();
  to_check_.erase(to_check_.begin());
  return waiting_.at(id);
}

void Dependents::check_again(const std::string& id) {
  if (waiting_.contains(id)) to_check_.insert(id);
}

}  // namespace dccast::jobs
