#pragma once

#include <optional>
#include <stdexcept>
#include <string>

#include "dccast/v1/refusal.pb.h"

namespace google::protobuf {
class Message;
}

/// Why a call is refused, for programs: what refusal.proto says, as the server writes it and the
/// client reads it.
namespace dccast::refusal {

using Reason = v1::ErrorInfo::Reason;

/// The parts of a refusal. People read message(); programs read the parts.
struct Facts {
  Reason reason = v1::ErrorInfo::REASON_UNSPECIFIED;
  std::string cause{};      ///< one sentence
  std::string limit{};      ///< key of the setting that refuses; empty: no limit does
  std::string permitted{};  ///< value of the limit, with its unit
  std::string remedy{};     ///< what to do; empty: the cause says it, or nothing helps

  /// "CAUSE; LIMIT = PERMITTED; REMEDY", without the parts that are empty.
  std::string message() const;
};

/// A limit refuses what a caller asks for; what() is the message of the facts.
class LimitReached : public std::runtime_error {
public:
  /// @param facts  the reason need not be set
  explicit LimitReached(Facts facts);
  const Facts& facts() const { return facts_; }

private:
  Facts facts_;
};

/// Serialises the details of a status.
/// @param code    number of the status code
/// @param detail  further message, such as the faults of a case; null: none
std::string write_details(int code, const Facts& facts,
                          const google::protobuf::Message* detail = nullptr);

/// Reads the details of a status. Empty if dccastd has not written them: gRPC itself refuses calls,
/// too.
std::optional<Facts> read_details(const std::string& details);

/// Reads the further message of a status. @return false if the details hold none of this type
bool read_detail(const std::string& details, google::protobuf::Message& to);

}  // namespace dccast::refusal
