#include "proto/case_file/override.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <set>
#include <span>
#include <string>

#include "proto/case_file/alloy_cards.hpp"
#include "proto/case_file/quantity.hpp"
#include "proto/case_file/schema.hpp"
#include "proto/case_file/toml_walker.hpp"
#include "proto/case_file/uncertainty.hpp"

namespace dccast::case_file {
namespace {

/// The action of a change on its key.
enum class Action {
  set,
  set_point,  ///< of a table: "melt_conductivity_factor[1]"
  recipe,     ///< sets the table of a factor: "0.8 until 100 mm"
  scale,      ///< multiplies the present value, a table as a whole
  offset      ///< adds to the present value
};

/// To what a change may be relative.
enum class Relative {
  to_case,  ///< to values of the case alone
  to_card   ///< to a value of the alloy card too, where the case leaves it to the card
};

/// The key that a path leads to.
struct Target {
  Message* message = nullptr;
  const FieldDescriptor* field = nullptr;
  std::string path;  ///< of the key itself, also if a recipe word was given
  Action action = Action::set;
  std::size_t point = 0;  ///< index, for set_point
};

bool is_real(const FieldDescriptor& field) {
  return is_curve(field) ||
         (field.cpp_type() == FieldDescriptor::CPPTYPE_DOUBLE && !field.is_repeated());
}

/// Follows the path of a change through the tables of a case; adds a fault if it leads nowhere.
class Finder {
public:
  Finder(Walk& walk, const toml::node& value) : walk_(walk), value_(value) {}

  std::optional<Target> find(Message& root, const std::vector<Segment>& segments) {
    Message* message = &root;
    std::string path;
    for (std::size_t i = 0; i < segments.size(); ++i) {
      const Segment& segment = segments[i];
      const FieldDescriptor* const field = field_of_key(*message->GetDescriptor(), segment.key);
      if (field == nullptr) {
        add_unknown(walk_, value_, *message, path, segment.key);
        return std::nullopt;
      }
      if (!is_table(*field))
        return resolve_key(*message, *field, {segments.begin() + i, segments.end()}, path);

      path = join_path(path, segment.key);
      if (i + 1 == segments.size()) return refuse_table(*field, path);
      message = enter(*message, *field, segment, path);
      if (message == nullptr) return std::nullopt;
      if (segment.element) path = element_path(path, *segment.element);
    }
    return std::nullopt;
  }

private:
  std::nullopt_t refuse(const std::string& path, const std::string& message,
                        const std::string& permitted, const std::string& remedy = {}) {
    walk_.refuse(value_, path, message, permitted, remedy);
    return std::nullopt;
  }

  std::nullopt_t refuse_table(const FieldDescriptor& field, const std::string& path) {
    const std::string below = field.is_repeated() ? element_path(path, 0) : path;
    return refuse(
        path, "a table; a change sets one key", "a key of the table",
        fmt::format("e.g. {}", join_path(below, toml_key(*field.message_type()->field(0)))));
  }

  /// The target of a key. @param parts  the path from the key on: the key, perhaps a recipe word
  std::optional<Target> resolve_key(Message& message, const FieldDescriptor& field,
                                    std::span<const Segment> parts, const std::string& path) {
    const auto& [name, element] = parts[0];
    const std::string key_path = join_path(path, name);
    if (element) {
      if (!is_curve(field) || parts.size() > 1)
        return refuse(key_path, "this key is no list of tables", "");
      return Target{&message, &field, element_path(key_path, *element), Action::set_point,
                    *element};
    }
    if (parts.size() == 1) return Target{&message, &field, key_path};

    const std::string& word = parts[1].key;
    const bool last = parts.size() == 2;

    if (const FieldDescriptor* const factor = recipe_field(field, word); factor != nullptr && last)
      return Target{&message, factor, join_path(path, toml_key(*factor)),
                    word == "scale" ? Action::recipe : Action::set};
    if (last && is_real(field) && (word == "scale" || word == "offset"))
      return Target{&message, &field, key_path, word == "scale" ? Action::scale : Action::offset};
    return refuse(join_path(key_path, word), "unknown key",
                  recipe_paths(*message.GetDescriptor(), path));
  }

  /// The table that a segment names; the index after the last one adds a table.
  Message* enter(Message& message, const FieldDescriptor& field, const Segment& segment,
                 const std::string& path) {
    const Reflection& reflection = *message.GetReflection();
    const auto& element = segment.element;
    if (!field.is_repeated()) {
      if (!element) return reflection.MutableMessage(&message, &field);
      refuse(path, "this table is no list", "", fmt::format("leave out [{}]", *element));
      return nullptr;
    }

    const auto count = static_cast<std::size_t>(reflection.FieldSize(message, &field));
    if (!element || *element > count) {
      refuse(path, element ? "there is none with this number" : "which of them is missing",
             fmt::format("{} to {}, the last one is new", element_path(path, 0),
                         element_path(path, count)));
      return nullptr;
    }

    if (*element < count)
      return reflection.MutableRepeatedMessage(&message, &field, static_cast<int>(*element));
    const bool fits = Entry{walk_, value_, field, path}.passes(count_fault(field, count + 1, path));
    return fits ? reflection.AddMessage(&message, &field) : nullptr;
  }

  Walk& walk_;
  const toml::node& value_;
};

void collect_files(const Message& message, std::set<std::string>& names) {
  const Reflection& reflection = *message.GetReflection();
  std::vector<const FieldDescriptor*> fields;
  reflection.ListFields(message, &fields);
  for (const FieldDescriptor* const field : fields) {
    if (is_table(*field) && !field->is_repeated())
      collect_files(reflection.GetMessage(message, field), names);
    else if (key_of(*field).attachment())
      names.insert(reflection.GetString(message, field));
  }
}

/// Applies the changes of one call to a message.
class Changes {
public:
  Changes(v1::Case& root, ReadOutcome& read, const std::filesystem::path* folder, Relative relative)
      : root_(root), read_(read), folder_(folder), relative_(relative) {}

  void apply(const v1::CaseChange& change) {
    ReadOutcome outcome;
    outcome.attachments = std::move(read_.attachments);

    // How the value is read depends on its key, so the key is looked up first; faults of the key
    // are reported at the untyped value.
    Walk walk{folder_, outcome};
    const ChangeValue untyped = change_value(change.value(), nullptr);
    const auto target = find(walk, untyped.node(), change, root_);
    const ChangeValue value = change_value(change.value(), target ? target->field : nullptr);
    if (target && begin(walk, value.node(), *target)) set(walk, value.node(), *target, change);

    if (target) read_.source.set(target->path, {0, value_column(change, 1)}, change_origin(change));
    report(outcome, change, value, target && target->action == Action::recipe);
    read_.attachments = std::move(outcome.attachments);
  }

private:
  static std::string change_origin(const v1::CaseChange& change) {
    return fmt::format("--set {}", change.key());
  }

  /// Converts a column of the value to the column in KEY=VALUE.
  static int value_column(const v1::CaseChange& change, int column) {
    return static_cast<int>(change.key().size()) + 1 + column;
  }

  static std::optional<Target> find(Walk& walk, const toml::node& value,
                                    const v1::CaseChange& change, Message& root) {
    if (const auto segments = segments_of(change.key()); !segments.empty())
      return Finder(walk, value).find(root, segments);
    walk.add(make_fault(change.key(), change.value(), "not the path of a key", "",
                        "e.g. schedule.hold or monitor[0].x"),
             value);
    return std::nullopt;
  }

  /// Removes faults and positions that the file has for the key. @return false, with a fault, if
  /// the change cannot be made
  bool begin(Walk& walk, const toml::node& value, const Target& target) {
    if (!changed_.insert(target.path).second) {
      walk.refuse(value, target.path, "is set twice", "", "keep one of them");
      return false;
    }

    const bool names_one = names_file(*target.field, value.value<std::string>().value_or(""));
    if (names_one && folder_ == nullptr) {
      walk.refuse(value, target.path, "names a file, which a change cannot bring", "",
                  "name the file in the case");
      return false;
    }

    std::erase_if(read_.faults,
                  [&](const v1::Fault& fault) { return covers(target.path, fault.field()); });
    read_.source.erase(target.path);
    if (key_of(*target.field).attachment()) forget_file(walk, target);
    return true;
  }

  /// Clears a key that names a file, and drops attachments that no key names any more.
  void forget_file(Walk& walk, const Target& target) {
    target.message->GetReflection()->ClearField(target.message, target.field);
    std::set<std::string> names;
    collect_files(root_, names);
    std::erase_if(walk.outcome.attachments,
                  [&](const AttachedFile& file) { return !names.contains(file.name); });
  }

  void set(Walk& walk, const toml::node& value, const Target& target,
           const v1::CaseChange& change) const {
    const Entry entry{walk, value, *target.field, target.path};
    if (target.action == Action::set || (target.action == Action::recipe && value.is_array()))
      return read_field(entry, *target.message);
    if (target.action != Action::recipe) return adjust(entry, target, change);
    set_curve(target, read_scale(walk, change.value(), *target.field, target.path));
  }

  static void set_curve(const Target& target, const v1::Curve& curve) {
    const Reflection& reflection = *target.message->GetReflection();
    if (curve.value_size() > 0)
      reflection.MutableMessage(target.message, target.field)->CopyFrom(curve);
  }

  /// Applies the number of a change to the present values: scale, offset or one point.
  void adjust(const Entry& entry, const Target& target, const v1::CaseChange& change) const {
    const std::string& own_unit = key_of(entry.field).unit();
    const std::string unit = target.action == Action::scale                          ? "1"
                             : target.action == Action::offset && own_unit == "degC" ? "K"
                                                                                     : own_unit;
    const auto number =
        read_number(entry.walk, entry.node, unit, example_text(entry.field), nullptr, entry.path);
    if (!number) return;

    v1::Curve curve = present_values(target);
    if (curve.value().empty()) curve = values_of_card(entry, change);
    if (target.point >= static_cast<std::size_t>(curve.value_size()))
      return entry.refuse("there is no value here to change", "", remedy_without_value(change));

    for (int i = 0; i < curve.value_size(); ++i) {
      double value = curve.value(i);
      if (target.action == Action::scale) value *= *number;
      if (target.action == Action::offset) value += *number;
      if (target.action == Action::set_point && static_cast<std::size_t>(i) == target.point)
        value = *number;

      if (!entry.passes(
              range_fault(entry.field, value, entry.path, quantity_text(value, own_unit), "")))
        return;
      curve.set_value(i, value);
    }

    if (is_curve(entry.field)) return set_curve(target, curve);
    target.message->GetReflection()->SetDouble(target.message, target.field, curve.value(0));
  }

  /// The values of the key as a table: a number is one point, an absent key has no point.
  static v1::Curve present_values(const Target& target) {
    if (is_curve(*target.field)) return curve_of(*target.message, *target.field);
    v1::Curve curve;
    if (const auto number = number_of(*target.message, *target.field)) curve.add_value(*number);
    return curve;
  }

  static bool is_alloy_key(const v1::CaseChange& change) {
    return change.key().starts_with("alloy.");
  }

  static std::string remedy_without_value(const v1::CaseChange& change) {
    return is_alloy_key(change)
               ? "give the key in the case; `dccast alloys CARD` prints those of a card"
               : "give the key in the case";
  }

  /// The values of a key that the case leaves to its alloy card; empty if the card is not at hand.
  v1::Curve values_of_card(const Entry& entry, const v1::CaseChange& change) const {
    if (relative_ == Relative::to_case || !is_alloy_key(change)) return {};

    v1::Case resolved = root_;
    apply_defaults(*resolved.mutable_alloy());
    const AlloyCard card = card_of(resolved.alloy().card(), entry.walk.outcome.attachments);
    if (!card.ok()) return {};

    *resolved.mutable_alloy() = root_.alloy();
    complete_alloy(card.alloy, *resolved.mutable_alloy());
    const auto target = find(entry.walk, entry.node, change, resolved);
    return target ? present_values(*target) : v1::Curve{};
  }

  /// A card of one's own, which the case brings, or one that the program knows.
  static AlloyCard card_of(const std::string& name, const std::vector<AttachedFile>& attachments) {
    const auto brought = std::ranges::find(attachments, name, &AttachedFile::name);
    if (brought == attachments.end()) return alloy_card(name);

    std::ifstream file(brought->path, std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    return own_card(name, text);
  }

  /// Adds the faults of a change to those of the case, with their positions in KEY=VALUE.
  void report(const ReadOutcome& outcome, const v1::CaseChange& change, const ChangeValue& value,
              bool is_scale) {
    for (const v1::Fault& fault : outcome.faults) {
      int column = std::max(outcome.source.find(fault.field()).column, 1);
      if (!is_scale && column <= static_cast<int>(value.columns.size()))
        column = value.columns[static_cast<std::size_t>(column) - 1];
      read_.source.set(fault.field(), {0, value_column(change, column)}, change_origin(change));
      read_.faults.push_back(fault);
    }
  }

  v1::Case& root_;
  ReadOutcome& read_;
  const std::filesystem::path* folder_;  // null: no files
  Relative relative_;
  std::set<std::string> changed_;
};

/// Whether a range that the case gives does not hold any more once a change has been made: that of
/// a value, or of one of its points, which is replaced; of one that is moved a range between two
/// values, but not "± 3 K".
bool is_void(const v1::KeyRange& range, const std::string& changed) {
  std::string key = changed;
  for (const std::string suffix : {".scale", ".offset"})
    if (key.ends_with(suffix)) key.resize(key.size() - suffix.size());
  if (range.key() != key && !range.key().starts_with(key + "[")) return false;
  if (key == changed) return true;

  const auto ends = parse_range(range.range());
  return ends && ends->suffix.empty();
}

/// Applies changes in order. @param folder  of files; null: a change that names one is refused
void apply_all(v1::Case& description, const std::vector<v1::CaseChange>& changes, ReadOutcome& read,
               const std::filesystem::path* folder, Relative relative) {
  Changes applied(description, read, folder, relative);
  for (const v1::CaseChange& change : changes) {
    applied.apply(change);
    auto& ranges = *description.mutable_uncertainty();
    ranges.erase(std::remove_if(ranges.begin(), ranges.end(),
                                [&](const auto& range) { return is_void(range, change.key()); }),
                 ranges.end());
  }
}

}  // namespace

v1::CaseChange change_of(const std::string& key, const std::string& value) {
  v1::CaseChange change;
  change.set_key(key);
  change.set_value(value);
  return change;
}

std::optional<v1::CaseChange> parse_change(std::string_view text) {
  const auto equals = text.find('=');
  if (equals == std::string_view::npos) return std::nullopt;
  const std::string key(trimmed(text.substr(0, equals)));
  if (key.empty()) return std::nullopt;
  return change_of(key, std::string(trimmed(text.substr(equals + 1))));
}

std::vector<v1::Fault> apply_changes(v1::Case& description,
                                     const std::vector<v1::CaseChange>& changes) {
  ReadOutcome read;
  apply_all(description, changes, read, nullptr, Relative::to_case);
  return std::move(read.faults);
}

void apply_changes(v1::Case& description, const std::vector<v1::CaseChange>& changes,
                   ReadOutcome& read, const std::filesystem::path& folder) {
  apply_all(description, changes, read, &folder, Relative::to_card);
}

void apply_changes_elsewhere(v1::Case& description, const std::vector<v1::CaseChange>& changes,
                             ReadOutcome& read) {
  apply_all(description, changes, read, nullptr, Relative::to_card);
}

}  // namespace dccast::case_file
