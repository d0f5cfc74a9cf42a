#include "server/service/labels.hpp"

#include "proto/values/printable.hpp"

namespace dccast::service {

namespace {

constexpr int most_labels = 20;
constexpr std::size_t longest_label = 64;             // bytes
constexpr std::size_t most_bytes_of_changes = 16384;  // they are shown in lists of 1000 jobs

grpc::Status refused(const std::string& what) {
  return {grpc::StatusCode::INVALID_ARGUMENT, what};
}

}  // namespace

grpc::Status check_labels(const google::protobuf::RepeatedPtrField<std::string>& labels) {
  if (labels.size() > most_labels)
    return refused("there are " + std::to_string(labels.size()) + " labels; a job has at most " +
                   std::to_string(most_labels));
  for (const std::string& label : labels) {
    const std::string given = "the label \"" + values::escaped(values::shortened(label)) + "\" ";
    if (label.empty() || label.size() > longest_label)
      return refused(given + "is not one line of 1 to " + std::to_string(longest_label) + " bytes");
    if (const auto character = values::unprintable(label))
      return refused(given + "contains " + *character + "; leave that character out");
  }
  return grpc::Status::OK;
}

grpc::Status check_changes(const google::protobuf::RepeatedPtrField<v1::CaseChange>& changes) {
  std::size_t bytes = 0;
  for (const v1::CaseChange& change : changes) {
    bytes += change.ByteSizeLong();
    for (const std::string& text : {change.key(), change.value()})
      if (const auto character = values::unprintable(text, values::Lines::several))
        return refused("a change of the case contains " + *character);
  }
  if (bytes <= most_bytes_of_changes) return grpc::Status::OK;
  return refused("the changes of the case take " + std::to_string(bytes) + " bytes; at most " +
                 std::to_string(most_bytes_of_changes) + " are kept: write them into the case");
}

}  // namespace dccast::service
