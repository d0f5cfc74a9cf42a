#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <vector>

#include "dccast/v1/worker.pb.h"

namespace dccast::worker {

/// What a worker has to say, in its order, and, once it is to outlive its daemon, what it has said
/// until the daemon has stored it. Both ends count the reports (jobs::is_report): a new daemon
/// names the number that it has, and gets the rest. What is between two reports comes again when
/// the next report does: the daemon takes each of that once.
///
/// Not safe to use from several threads.
class Outbox {
public:
  /// @param keeps  from now on nothing is forgotten that the daemon may lack
  void keep(bool keeps) { keeps_ = keeps; }
  void add(v1::WorkerMessage message);
  /// What waits to be sent; it counts as sent from now on.
  std::vector<v1::WorkerMessage> take();
  /// The daemon has stored the first `reports` reports.
  void forget_stored(std::int64_t reports);
  /// A new daemon has stored the first `reports` reports: everything else waits to be sent again.
  /// @return false when it lacks something that was forgotten, or has what was never said
  bool rewind(std::int64_t reports);

  bool has_unsent() const { return sent_ < messages_.size(); }
  /// Whether it holds so much that the run must wait.
  bool is_full() const;
  /// Whether the last word of the worker was sent.
  bool said_last_word() const { return said_last_word_; }

private:
  struct Entry {
    v1::WorkerMessage message;
    std::int64_t number = 0;  ///< of reports up to this message, itself among them
    std::size_t bytes = 0;
  };
  bool is_stored(const Entry& entry, std::int64_t reports) const;

  bool keeps_ = false;
  bool said_last_word_ = false;
  std::deque<Entry> messages_;
  std::size_t sent_ = 0;        ///< of messages_
  std::size_t bytes_ = 0;       ///< of messages_
  std::int64_t reports_ = 0;    ///< added so far
  std::int64_t forgotten_ = 0;  ///< reports that are no longer here
};

}  // namespace dccast::worker
