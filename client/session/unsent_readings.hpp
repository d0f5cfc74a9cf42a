#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <filesystem>
#include <mutex>
#include <stop_token>
#include <string>
#include <vector>

#include "client/session/mqtt.hpp"
#include "client/session/readings_table.hpp"

namespace dccast::client {

/// Readings that the server does not have yet. They are kept in a file (mode 0600), so that they
/// outlive this program; the file goes once all are acknowledged. Safe to use from two threads, one
/// that adds and one that sends.
class UnsentReadings {
public:
  /// Most that is kept [bytes].
  static constexpr std::size_t most_bytes = 64 << 20;

  /// Begins with what an earlier program has left.
  /// @param file    of the job; empty: they are kept in memory alone
  /// @param remark  receives what cannot be kept, and that there is no more room
  UnsentReadings(std::filesystem::path file, Remark remark);
  UnsentReadings(const UnsentReadings&) = delete;
  ~UnsentReadings();

  /// Adds readings. While there is no room it waits. @return false if the stop was requested
  bool add(std::vector<ReadingOfLine> readings, std::stop_token stop);
  /// No more are added.
  void close();

  /// The oldest readings, at most 1,000; waits for them. Empty: all were acknowledged and no more
  /// come, or the stop was requested.
  std::vector<ReadingOfLine> next(std::stop_token stop);
  /// The server has the oldest readings.
  void acknowledge(std::size_t count);
  std::size_t size() const;

private:
  /// @return why there is no file; empty: it is open, and of this program alone
  std::string open_file();
  void read_left();
  void write(const std::string& text);

  std::filesystem::path file_;
  Remark remark_;
  int descriptor_ = -1;  ///< of the file; -1: there is none
  mutable std::mutex mutex_;
  std::condition_variable_any changed_;
  std::deque<ReadingOfLine> unsent_;
  /// Of the file, also of readings that were acknowledged since it was empty.
  std::size_t bytes_ = 0;
  bool closed_ = false;
  bool is_full_ = false;
};

/// Where readings of a job are kept, $XDG_STATE_HOME/dccast/readings/JOB; empty: there is no home.
std::filesystem::path unsent_readings_file(const std::string& job);

}  // namespace dccast::client
