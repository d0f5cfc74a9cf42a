#include "server/worker/outbox.hpp"

#include <utility>

namespace dccast::worker {

namespace {

// Of a casting with few monitors hours; of one with many, some hundred steps.
constexpr std::size_t most_messages = 4096;
constexpr std::size_t most_bytes = 64u << 20;

/// Whether the daemon counts a message when it has stored it: jobs::is_report().
bool is_report(const v1::WorkerMessage& message) {
  return message.has_step() || message.has_resumed() ||
         message.message().level() == v1::JobEvent::Message::INFO;
}

}  // namespace

void Outbox::add(v1::WorkerMessage message) {
  if (is_report(message)) ++reports_;
  const std::size_t bytes = message.ByteSizeLong();
  bytes_ += bytes;
  messages_.push_back({std::move(message), reports_, bytes});
}

std::vector<v1::WorkerMessage> Outbox::take() {
  std::vector<v1::WorkerMessage> taken;
  for (; sent_ < messages_.size(); ++sent_) {
    said_last_word_ = messages_[sent_].message.has_finished();
    taken.push_back(messages_[sent_].message);
  }
  if (!keeps_) forget_stored(reports_);
  return taken;
}

bool Outbox::is_stored(const Entry& entry, std::int64_t reports) const {
  return is_report(entry.message) ? entry.number <= reports : entry.number < reports;
}

void Outbox::forget_stored(std::int64_t reports) {
  while (sent_ > 0 && (!keeps_ || is_stored(messages_.front(), reports))) {
    forgotten_ = messages_.front().number;
    bytes_ -= messages_.front().bytes;
    messages_.pop_front();
    --sent_;
  }
}

bool Outbox::rewind(std::int64_t reports) {
  if (reports < forgotten_ || reports > reports_) return false;
  sent_ = messages_.size();
  forget_stored(reports);
  sent_ = 0;
  said_last_word_ = false;
  return true;
}

bool Outbox::is_full() const {
  return messages_.size() >= most_messages || bytes_ >= most_bytes;
}

}  // namespace dccast::worker
