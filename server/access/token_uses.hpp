#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <string>

namespace dccast::access {

/// Last use of a token.
struct TokenUse {
  std::int64_t unix_s = 0;  ///< [s since 1970]
  std::string address{};    ///< of the client, as gRPC writes it
};

/// When and from where each token was last used since the daemon started. In memory alone: a call
/// must not cause a write. Safe to use from several threads.
class TokenUses {
public:
  /// Beyond it, the token that was not used for the longest time is forgotten.
  static constexpr std::size_t most_kept = 10000;

  /// @param id  public part of the token
  void note(const std::string& id, TokenUse use);
  /// @return nothing: it was not used since the start
  std::optional<TokenUse> last(const std::string& id);

private:
  std::mutex mutex_;
  std::map<std::string, TokenUse> uses_;
};

}  // namespace dccast::access
