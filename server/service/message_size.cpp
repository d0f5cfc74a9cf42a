#include "server/service/message_size.hpp"

#include <google/protobuf/descriptor.h>

#include <string>
#include <vector>

#include "proto/values/printable.hpp"

namespace dccast::service {

namespace {

constexpr std::size_t most_of_a_title = 1024;
constexpr std::size_t most_of_a_job = 64 * 1024;
constexpr int most_residuals = 1000;

/// Cuts a text between two characters of UTF-8.
void cut(std::string& text, std::size_t most) {
  if (text.size() <= most) return;
  std::size_t end = most;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xc0) == 0x80) --end;
  text.resize(end);
  text += "...";
}

std::string printable(const std::string& text) {
  return values::escaped(text, values::Lines::several);
}

void cut_failure(v1::Failure& failure) {
  cut(*failure.mutable_message(), most_of_a_job / 8);
  if (failure.residual_history_size() > most_residuals)
    failure.mutable_residual_history()->Truncate(most_residuals);
  while (failure.ByteSizeLong() > most_of_a_job / 2 && failure.further_causes_size() > 0)
    failure.mutable_further_causes()->RemoveLast();
}

}  // namespace

void fit_into_list(v1::Job& job) {
  cut(*job.mutable_title(), most_of_a_title);
  if (job.ByteSizeLong() <= most_of_a_job) return;
  if (job.has_last_step()) job.mutable_last_step()->clear_monitors();
  if (job.has_failure()) cut_failure(*job.mutable_failure());
}

void make_printable(google::protobuf::Message& message) {
  using google::protobuf::FieldDescriptor;
  const auto* reflection = message.GetReflection();
  std::vector<const FieldDescriptor*> fields;
  reflection->ListFields(message, &fields);
  for (const FieldDescriptor* field : fields) {
    const bool text = field->type() == FieldDescriptor::TYPE_STRING;
    const int count = field->is_repeated() ? reflection->FieldSize(message, field) : 1;
    for (int i = 0; i < count && (text || field->message_type() != nullptr); ++i) {
      if (text && field->is_repeated())
        reflection->SetRepeatedString(
            &message, field, i, printable(reflection->GetRepeatedString(message, field, i)));
      else if (text)
        reflection->SetString(&message, field, printable(reflection->GetString(message, field)));
      else
        make_printable(field->is_repeated()
                           ? *reflection->MutableRepeatedMessage(&message, field, i)
                           : *reflection->MutableMessage(&message, field));
    }
  }
}

}  // namespace dccast::service
