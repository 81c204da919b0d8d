// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/options/session_config.hpp"

#include <fstream>
#include <map>
#include <sstream>

#include "app/options/option.hpp"
#include "app/options/retired.hpp"
#include "app/options/session_section.hpp"
#include "io/json.hpp"
#include "session/live_devices.hpp"

namespace nav::app {
namespace {

/// "look.cutaway.enabled" is "enabled" of the table "look.cutaway".
std::string table_of(const std::string& key) {
  const auto dot = key.rfind('.');
  return dot == std::string::npos ? "" : key.substr(0, dot);
}
const char* name_in_table(const Option& option) {
  const auto dot = option.key.rfind('.');
  return option.key.c_str() + (dot == std::string::npos ? 0 : dot + 1);
}

/// One row for each key: the first, where several options of different verbs set it.
std::vector<const Option*> rows_of_keys() {
  std::vector<const Option*> rows;
  std::set<std::string> seen;
  for (const Option& option : option_table()) {
    if (!option.key.empty() && seen.insert(option.key).second) rows.push_back(&option);
  }
  return rows;
}

void read_key(Section& section, const Option& option, Settings& settings) {
  const char* key = name_in_table(option);
  if (option.read != nullptr) return option.read(section, key, settings);
  if (!option.retired.empty()) {
    double value = 0;  // Session files of the last version have the key, usually 0.
    section.number(key, value);
    if (value != 0) warn_retired(option.key, option.retired);
    return;
  }
  const auto numbers = [&](std::size_t count, auto use) {
    std::vector<double> found;
    section.numbers(key, count, found);
    if (!found.empty()) use(found.data());
  };
  std::visit(
      [&](auto at) {
        using T = std::remove_pointer_t<decltype(at)>;
        if constexpr (std::is_same_v<T, bool> || std::is_same_v<T, std::optional<bool>>) {
          section.flag(key, *at);
        } else if constexpr (std::is_same_v<T, int> || std::is_same_v<T, std::uint64_t>) {
          section.integer(key, *at);
        } else if constexpr (std::is_same_v<T, std::optional<int>>) {
          section.whole_number(key, *at);
        } else if constexpr (std::is_same_v<T, double>) {
          section.number(key, *at);
        } else if constexpr (std::is_same_v<T, std::optional<double>>) {
          const bool infinite = option.range && std::isinf(option.range->high);
          infinite ? section.number_or_infinity(key, *at) : section.number(key, *at);
        } else if constexpr (std::is_same_v<T, std::string>) {
          section.text(key, *at);
        } else if constexpr (std::is_same_v<T, std::optional<std::string>>) {
          std::string text;
          section.text(key, text);
          if (!text.empty()) *at = text;
        } else if constexpr (std::is_same_v<T, std::filesystem::path>) {
          section.path(key, *at);
        } else if constexpr (std::is_same_v<T, std::vector<std::filesystem::path>>) {
          std::vector<std::string> names;
          section.texts(key, names);
          for (const auto& name : names) at->push_back(section.beside_file(name));
        } else if constexpr (std::is_same_v<T, Eigen::Vector3d> ||
                             std::is_same_v<T, std::optional<Eigen::Vector3d>>) {
          numbers(3, [&](const double* v) { *at = Eigen::Map<const Eigen::Vector3d>(v); });
        } else if constexpr (std::is_same_v<T, std::optional<Eigen::Vector2d>>) {
          numbers(2, [&](const double* v) { *at = Eigen::Map<const Eigen::Vector2d>(v); });
        } else if constexpr (std::is_same_v<T, std::optional<Eigen::Vector4d>>) {
          numbers(4, [&](const double* v) { *at = Eigen::Map<const Eigen::Vector4d>(v); });
        } else if constexpr (std::is_same_v<T, std::optional<Eigen::Matrix<double, 6, 1>>>) {
          using Vector6d = Eigen::Matrix<double, 6, 1>;
          numbers(6, [&](const double* v) { *at = Eigen::Map<const Vector6d>(v); });
        }
      },
      option.slot(settings));
}

template <class Vector>
toml::array array_of(const Vector& vector) {
  toml::array array;
  for (const double x : vector) array.push_back(x);
  return array;
}

template <class T>
void write_value(const KeyWriter& writer, const Option& option, const T& value) {
  const char* key = name_in_table(option);
  if constexpr (std::is_same_v<T, bool> || std::is_same_v<T, double> ||
                std::is_same_v<T, std::string>) {
    writer.table.insert(key, value);
  } else if constexpr (std::is_integral_v<T>) {
    writer.table.insert(key, static_cast<std::int64_t>(value));
  } else if constexpr (std::is_same_v<T, std::filesystem::path>) {
    if (!value.empty() || !option.written_when_set) writer.table.insert(key, writer.path(value));
  } else if constexpr (std::is_same_v<T, std::vector<std::filesystem::path>>) {
    toml::array paths;
    for (const auto& path : value) paths.push_back(writer.path(path));
    if (!paths.empty()) writer.table.insert(key, std::move(paths));
  } else if constexpr (std::is_base_of_v<Eigen::DenseBase<T>, T>) {
    writer.table.insert(key, array_of(value));
  }
}

template <class T>
void write_value(const KeyWriter& writer, const Option& option, const std::optional<T>& value) {
  if (value) write_value(writer, option, *value);
}

void write_key(KeyWriter& writer, const Option& option, Settings& settings) {
  if (option.write != nullptr) {
    return option.write(writer, name_in_table(option), settings);
  }
  if (!option.retired.empty()) return;
  std::visit(
      [&](auto at) {
        if constexpr (!std::is_same_v<decltype(at), std::monostate>) {
          write_value(writer, option, *at);
        }
      },
      option.slot(settings));
}

/// Parts of a session that it does not have.
void drop_empty_tables(toml::table& table) {
  for (auto at = table.begin(); at != table.end();) {
    toml::table* inside = at->second.as_table();
    if (inside != nullptr) drop_empty_tables(*inside);
    at = inside != nullptr && inside->empty() ? table.erase(at) : std::next(at);
  }
}

/// Rejects values of the keys that begin with \p begin which are out of range or break a rule.
Result<void> check_keys(std::string_view begin, const Settings& settings) {
  for (const Option* option : rows_of_keys()) {
    if (option->slot == nullptr || !option->key.starts_with(begin)) continue;
    if (const auto ok = check_value(*option, settings); !ok) {
      return Error{ok.error().code, option->key + ": " + ok.error().message};
    }
  }
  for (const Option* option : rows_of_keys()) {
    if (!option->key.starts_with(begin)) continue;
    for (const Requirement& rule : option->always) {
      if (rule.met(settings)) continue;
      return Error{ErrorCode::kUsage,
                   option->key + ": expected " + rule.text + ", found " + rule.found(settings)};
    }
  }
  return {};
}

/// Reads the keys of one table and the tables inside of it, and rejects all other keys.
void read_table(Section& section, const std::string& name,
                const std::map<std::string, std::vector<const Option*>>& tables,
                Settings& settings) {
  for (const Option* option : tables.at(name)) read_key(section, *option, settings);
  for (const auto& [inner, options] : tables) {
    if (inner.empty() || table_of(inner) != name) continue;
    Section inside = section.inside(inner, section.table(inner.substr(name.size() + 1).c_str()));
    read_table(inside, inner, tables, settings);
  }
  section.finish();
}

SessionConfig read_tables(const toml::table& root, const std::string& file,
                          std::optional<Error>& error) {
  Settings settings;
  settings.config.file = file;
  std::map<std::string, std::vector<const Option*>> tables;
  std::set<std::string> names;
  std::set<std::string> lists;
  for (const Option* option : rows_of_keys()) {
    tables[table_of(option->key)].push_back(option);
    names.insert(option->key.substr(0, option->key.find('.')));
    if (table_of(option->key).empty()) lists.insert(option->key);
  }
  for (const auto& [key, node] : root) {
    const std::string name(key.str());
    if (error || lists.contains(name)) continue;
    if (names.contains(name) && node.is_table()) continue;
    std::string known;
    for (const std::string& one : names) known.append(known.empty() ? "" : ", ").append(one);
    error = Error{ErrorCode::kMalformedData, file + ":" + std::to_string(node.source().begin.line) +
                                                 ": unknown section '" + name +
                                                 "', expected one of " + known};
  }
  Section whole(file, "", &root, error);
  for (const auto& [name, options] : tables) {
    if (name.empty()) {
      for (const Option* option : options) read_key(whole, *option, settings);
    } else if (table_of(name).empty()) {
      Section section(file, name, root[name].as_table(), error);
      read_table(section, name, tables, settings);
    }
  }
  return settings.config;
}

/// Rejects keys of very many parts, which would exhaust the stack of the parser.
Result<void> check_depth(const std::filesystem::path& path) {
  constexpr int kMostParts = 128;
  std::ifstream file(path);
  int line = 1;
  int parts = 0;
  char quote = 0;
  for (char c = 0; file.get(c);) {
    if (c == '\n') ++line;
    if (c == '\n' ||
        (quote == 0 && std::string_view(",={}[]#").find(c) != std::string_view::npos)) {
      parts = 0;
      if (c == '\n') quote = 0;
    } else if (c == '"' || c == '\'') {
      quote = quote == 0 ? c : quote == c ? '\0' : quote;
    } else if (quote == 0 && c == '.' && ++parts > kMostParts) {
      return Error{ErrorCode::kMalformedData,
                   path.string() + ":" + std::to_string(line) +
                       ": expected keys of at most 128 parts, found more"};
    }
  }
  return {};
}

bool is_utf8(const std::string& text) {
  try {
    (void)io::Json(text).dump();
    return true;
  } catch (const io::Json::exception&) {
    return false;
  }
}

/// The first text that TOML cannot hold: the library would write another in its place.
Result<void> check_texts(const toml::node& node, const std::string& key) {
  if (const auto* table = node.as_table()) {
    for (const auto& [name, value] : *table) {
      const std::string full = key.empty() ? std::string(name) : key + "." + std::string(name);
      if (const auto ok = check_texts(value, full); !ok) return ok;
    }
  } else if (const auto* list = node.as_array()) {
    for (const toml::node& value : *list) {
      if (const auto ok = check_texts(value, key); !ok) return ok;
    }
  } else if (const auto* text = node.as_string(); text != nullptr && !is_utf8(text->get())) {
    return Error{ErrorCode::kUsage,
                 key + ": expected UTF-8, as a session file is, found " + text->get()};
  }
  return {};
}

/// The beginning of a line of a file, for a message; lines are counted from 1.
std::string line_of(const std::filesystem::path& path, std::size_t number) {
  constexpr std::size_t kMost = 60;
  std::ifstream file(path);
  std::string line;
  for (std::size_t i = 0; i < number; ++i) {
    if (!std::getline(file, line)) return "the end of the file";
  }
  return line.size() > kMost ? line.substr(0, kMost) + "…" : line;
}

/// An error whose message has one line of usual length, whatever texts of the file it has.
Error in_one_line(const Error& error) {
  constexpr std::size_t kMost = 600;
  std::string message;
  for (const char c : error.message.substr(0, kMost)) {
    if (c == '\n') {
      message += "\\n";
    } else {
      message += c;
    }
  }
  if (error.message.size() > kMost) message += "…";
  return {error.code, message};
}

}  // namespace

Result<SessionConfig> read_session_config(const std::filesystem::path& path) {
  std::error_code status;
  if (!std::filesystem::is_regular_file(path, status)) {
    return Error{ErrorCode::kNotFound,
                 path.string() + ": expected a session file, found " +
                     (std::filesystem::exists(path, status) ? "something that is not a file"
                                                            : "nothing of that name")};
  }
  if (const auto ok = check_depth(path); !ok) return ok.error();
  toml::table root;
  try {
    root = toml::parse_file(path.string());
  } catch (const toml::parse_error& problem) {
    const auto& at = problem.source().begin;
    std::ostringstream text;
    text << path.string() << ":" << at.line << ": expected TOML, found '" << line_of(path, at.line)
         << "' (column " << at.column << ")";
    return Error{ErrorCode::kMalformedData, text.str()};
  }
  std::optional<Error> error;
  SessionConfig config = read_tables(root, path.string(), error);
  if (error) return in_one_line(*error);
  if (const auto ok = validate(config); !ok) {
    return in_one_line({ErrorCode::kMalformedData, path.string() + ": " + ok.error().message});
  }
  return config;
}

Result<void> validate(const SessionConfig& config) {
  Settings settings;
  settings.config = config;
  if (const auto ok = check_keys("", settings); !ok) return ok;
  const auto& placement = config.placement;
  if (placement.ct_from_reference) {
    const auto rigid =
        rigid_from_matrix<frames::Ct, frames::Reference>(*placement.ct_from_reference);
    if (!rigid) {
      return Error{ErrorCode::kUsage, "placement.ct_from_reference_mm: " + rigid.error().message};
    }
  }
  if (!config.appearance.nodes.empty()) {
    const auto made = render::TransferFunction::create("look.nodes", config.appearance.nodes);
    if (!made) return Error{ErrorCode::kUsage, "look.nodes: " + made.error().message};
  }
  if (config.plan) {
    if (const auto ok = validate(*config.plan); !ok) {
      return Error{ErrorCode::kUsage, ok.error().message};
    }
    if (config.source.kind == SessionConfig::SourceKind::kSimulated && !config.window.is_saved()) {
      return Error{ErrorCode::kUsage,
                   "plan: expected a recording, found the simulated procedure, which has its own"};
    }
  }
  if (const auto ok = session::validate(config.source.devices); !ok) return ok;
  if (const auto ok = session::validate(config.critical_structures); !ok) return ok;
  if (const auto ok = validate(config.cutaway_objects); !ok) return ok;
  if (const auto ok = validate(config.appearance); !ok) return ok;
  if (const auto ok = validate(config.predicates); !ok) return ok;
  return validate(config.window);
}

Result<void> validate(const SessionConfig::Appearance& appearance) {
  Settings settings;
  settings.config.appearance = appearance;
  if (const auto ok = check_keys("look.", settings); !ok) return ok;
  return {};
}

Result<void> require_path(const std::filesystem::path& path, const char* option, const char* what) {
  if (!path.empty()) return {};
  return Error{ErrorCode::kUsage, std::string(option) + ": expected " + what + ", found nothing"};
}

Result<std::string> to_toml(const SessionConfig& config, const std::filesystem::path& folder) {
  Settings settings;
  settings.config = config;
  toml::table root;
  for (const Option* option : rows_of_keys()) {
    toml::table* table = &root;
    const std::string name = table_of(option->key);
    for (std::size_t begin = 0; begin < name.size();) {
      const std::size_t end = std::min(name.find('.', begin), name.size());
      const std::string part = name.substr(begin, end - begin);
      if (!table->contains(part)) table->insert(part, toml::table{});
      table = table->get(part)->as_table();
      begin = end + 1;
    }
    KeyWriter writer{*table, folder};
    write_key(writer, *option, settings);
  }
  drop_empty_tables(root);
  if (const auto ok = check_texts(root, ""); !ok) return ok.error();
  std::ostringstream text;
  text << root << '\n';
  return text.str();
}

}  // namespace nav::app
