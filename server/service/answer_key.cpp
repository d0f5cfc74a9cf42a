#include "server/service/answer_key.hpp"

#include "server/service/case_intake.hpp"

namespace dccast::service {

std::string answer_key(const v1::Case& complete, const jobs::Attachments& attachments) {
  v1::Case deciding = complete;
  deciding.clear_title();
  deciding.clear_checkpoint();
  deciding.clear_uncertainty();
  deciding.mutable_alloy()->clear_uncertainty();
  return fingerprint(deciding, attachments);
}

}  // namespace dccast::service
