#include "server/intake/attachment_names.hpp"

#include <google/protobuf/descriptor.h>

#include <set>
#include <string>

#include "dccast/v1/options.pb.h"
#include "proto/values/printable.hpp"

namespace dccast::intake {

namespace {

v1::Fault fault(const std::string& field, const std::string& value, const std::string& message,
                const std::string& permitted, const std::string& remedy) {
  v1::Fault result;
  result.set_field(field);
  result.set_value(value);
  result.set_message(message);
  result.set_permitted(permitted);
  result.set_remedy(remedy);
  return result;
}

void check_names(const jobs::Attachments& attachments, std::set<std::string>& names,
                 v1::ValidateCaseResponse& verdict) {
  for (const v1::Attachment& attachment : attachments) {
    if (!jobs::is_plain_file_name(attachment.name()))
      *verdict.add_faults() = fault(
          attachments_field, values::escaped(attachment.name()), "is not the plain name of a file",
          "1 to 255 bytes without a slash, not \".\" or \"..\"", "attach it under its last name");
    else if (const auto character = values::unprintable(attachment.name()))
      *verdict.add_faults() =
          fault(attachments_field, values::escaped(attachment.name()), "contains " + *character,
                "characters that can be shown", "rename the file");
    else if (!names.insert(attachment.name()).second)
      *verdict.add_faults() = fault(attachments_field, attachment.name(), "is attached twice",
                                    "one file of a name", "rename one of them");
  }
}

/// Every file a message names must be attached; walks its tables.
void check_references(const google::protobuf::Message& message, const std::string& path,
                      const std::set<std::string>& attached, std::set<std::string>& used,
                      v1::ValidateCaseResponse& verdict) {
  const auto* reflection = message.GetReflection();
  std::vector<const google::protobuf::FieldDescriptor*> fields;
  reflection->ListFields(message, &fields);
  for (const auto* field : fields) {
    const std::string name = path.empty() ? field->name() : path + "." + field->name();
    if (field->message_type() != nullptr && !field->is_repeated()) {
      check_references(reflection->GetMessage(message, field), name, attached, used, verdict);
    } else if (field->options().GetExtension(v1::key).attachment()) {
      const std::string file = reflection->GetString(message, field);
      used.insert(file);
      if (!attached.contains(file))
        *verdict.add_faults() =
            fault(name, file, "is not among the attachments",
                  "the name of a file sent with the case", "send it with the case");
    }
  }
}

}  // namespace

void check_attachment_names(const v1::Case& submitted, const jobs::Attachments& attachments,
                            v1::ValidateCaseResponse& verdict) {
  std::set<std::string> names, used;
  check_names(attachments, names, verdict);
  check_references(submitted, "", names, used, verdict);
  for (const std::string& name : names)
    if (!used.contains(name))
      *verdict.add_warnings() = fault(attachments_field, name, "is not named in the case", "",
                                      "name it there, or leave it out");
}

}  // namespace dccast::intake
