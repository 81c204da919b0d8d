// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Tables of the documents, manual pages and completion, from the tables of verbs and options.
#include <algorithm>
#include <set>
#include <sstream>

#include "app/options/option_help.hpp"
#include "app/options/option_rows.hpp"

namespace nav::app {
namespace {

/// Groups that have a table of their own in the documents, and the verbs that refer to it.
const std::set<std::string> kSharedGroups{group::kGroupView, group::kGroupAppearance,
                                          group::kGroupRecording, group::kGroupScanLines};
const std::set<std::string> kSharingVerbs{"demo",     "replay", "live",
                                          "register", "slices", "predicates"};

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size()) {
    text.replace(at, from.size(), to);
  }
  return text;
}

std::string in_cell(const std::string& text) { return replaced(text, "|", "\\|"); }

/// "`--engine cpu\|gl\|reference`".
std::string option_cell(const Option& option) {
  std::string text = usage_text(option);
  if (!option.choices.empty() && option.choices.size() <= 4 && !is_argument(option)) {
    std::string choices;
    for (const auto& one : option.choices) choices += (choices.empty() ? "" : "|") + one;
    text = option.name + " " + choices;
  }
  return "`" + in_cell(text) + "`";
}

/// Defaults that differ between verbs are named with theirs.
std::string default_cell(const Option& option, const std::vector<std::string_view>& verbs) {
  if (option.required) return "required";
  if (is_flag(option)) return option.absent.empty() ? "off" : option.absent;
  const auto shown = [&](std::string_view verb) {
    const std::string value = value_text(option, default_settings(verb));
    if (value.empty()) return option.absent == "none" ? "–" : in_cell(option.absent);
    const bool word = std::isalpha(static_cast<unsigned char>(value.front())) != 0;
    return word ? "`" + value + "`" : value;
  };
  const std::string usual = shown(verbs.empty() ? "" : verbs.back());
  std::string text = usual;
  for (const std::string_view verb : verbs) {
    if (shown(verb) != usual) text += " (`" + std::string(verb) + "`: " + shown(verb) + ")";
  }
  return text;
}

/// The unit has a column of its own, and a few choices stand in the first.
std::string range_cell(const Option& option) {
  const bool choices_shown =
      !option.name.empty() && !option.choices.empty() && option.choices.size() <= 4;
  std::string range = choices_shown ? "" : range_text(option);
  if (!option.unit.empty() && range.ends_with(" " + option.unit)) {
    range.resize(range.size() - option.unit.size() - 1);
  }
  return in_cell(range);
}

const char* kOptionHead = "| option | unit | range | default | meaning |\n|---|---|---|---|---|\n";

std::string option_row(const Option& option, const std::vector<std::string_view>& verbs) {
  return "| " + option_cell(option) + " | " + in_cell(option.unit) + " | " + range_cell(option) +
         " | " + default_cell(option, verbs) + " | " + in_cell(option.text) + " |\n";
}

std::string verb_table_of(const Verb& verb) {
  std::string text = kOptionHead;
  for (const Option* option : options_of(verb.name)) {
    const bool elsewhere =
        kSharedGroups.contains(option->group) && kSharingVerbs.contains(verb.name);
    if (elsewhere || !option->retired.empty()) continue;
    text += option_row(*option, {verb.name});
  }
  return text;
}

std::string group_table_of(const std::string& name) {
  std::string text = kOptionHead;
  std::set<std::string> seen;
  for (const Option& option : option_table()) {
    if (option.group != name || option.name.empty() || !option.retired.empty()) continue;
    if (seen.insert(option.name).second) text += option_row(option, option.verbs);
  }
  return text;
}

std::string key_table() {
  std::string text =
      "| key | unit | range | default | meaning | option |\n|---|---|---|---|---|---|\n";
  std::vector<const Option*> rows;
  std::set<std::string> seen;
  for (const Option& option : option_table()) {
    if (option.key.empty() || !option.retired.empty()) continue;
    if (seen.insert(option.key).second) rows.push_back(&option);
  }
  std::ranges::stable_sort(
      rows, {}, [](const Option* option) { return option->key.substr(0, option->key.rfind('.')); });
  for (const Option* option : rows) {
    std::string standard = default_cell(*option, {});
    if (option->negates) standard = "true";
    if (is_flag(*option) && standard == "off") standard = "false";
    if (standard == "from the session file") standard = "–";
    Option nameless = *option;  // A key takes all choices, which no first column shows.
    nameless.name.clear();
    text += "| `" + option->key + "` | " + in_cell(option->unit) + " | " + range_cell(nameless) +
            " | " + standard + " | " + (option->negates ? "false: " : "") + in_cell(option->text) +
            " | " + (option->name.empty() ? "–" : "`" + option->name + "`") + " |\n";
  }
  return text;
}

/// A text of troff: a minus sign is an option's, and no line begins with a control character.
std::string troff(const std::string& text) {
  std::string escaped = replaced(replaced(text, "\\", "\\\\"), "-", "\\-");
  if (escaped.starts_with('.') || escaped.starts_with('\'')) escaped = "\\&" + escaped;
  return escaped;
}

Result<std::string> generated_table(const std::string& marker) {
  const auto after = [&](const std::string& begin) {
    const std::string end = " -->";
    return marker.starts_with(begin) && marker.ends_with(end)
               ? marker.substr(begin.size(), marker.size() - begin.size() - end.size())
               : "";
  };
  if (marker == "<!-- keys of the session file -->") return key_table();
  if (const std::string name = after("<!-- options of "); !name.empty()) {
    if (const Verb* verb = find_verb(name)) return verb_table_of(*verb);
  }
  if (const std::string name = after("<!-- options: "); kSharedGroups.contains(name)) {
    return group_table_of(name);
  }
  return Error{ErrorCode::kMalformedData, "expected a verb or a group of options, found " + marker};
}

}  // namespace

std::string man_page(const Verb& verb) {
  const Settings defaults = default_settings(verb.name);
  std::string text = ".TH SONDE\\-" + verb.name + " 1 \"\" \"Sonde " SONDE_VERSION "\"\n";
  text += ".SH NAME\nsonde\\-" + verb.name + " \\- " + troff(verb.summary) + "\n";
  text += ".SH SYNOPSIS\n.B sonde " + troff(verb.synopsis) + "\n[options]\n";
  const auto options = options_of(verb.name);
  std::vector<std::string> groups;
  for (const Option* option : options) {
    if (std::ranges::count(groups, option->group) == 0) groups.push_back(option->group);
  }
  text += ".SH OPTIONS\n";
  for (const std::string& one : groups) {
    text += ".SS " + troff(one) + "\n";
    for (const Option* option : options) {
      if (option->group != one || !option->retired.empty()) continue;
      const std::string details = detail_text(*option, defaults);
      text += ".TP\n.B " + troff(usage_text(*option)) + "\n" +
              troff(option->text + (details.empty() ? "" : " (" + details + ")")) + ".\n";
    }
  }
  text += ".SH EXAMPLES\n.nf\n";
  for (const std::string& example : verb.examples) text += troff(example) + "\n";
  text +=
      ".fi\n.SH EXIT STATUS\n0 done, 1 a bug in Sonde, 2 usage, 3 bad input, 4 a device or "
      "memory that is not available, 5 a result that was refused.\n";
  text +=
      ".SH SEE ALSO\nResearch software, not a medical device. "
      "Documents: docs/command\\-line.md.\n";
  return text;
}

std::string bash_completion(const std::vector<std::string>& verbs) {
  std::string names;
  for (const std::string& verb : verbs) names += (names.empty() ? "" : " ") + verb;
  std::string values;
  std::string options;
  for (const Verb& verb : verb_table()) {
    options += "    " + verb.name + ") words=\"--help --help-all";
    for (const Option* option : options_of(verb.name)) {
      if (is_argument(*option) || !option->retired.empty()) continue;
      options += " " + option->name;
      if (option->choices.empty()) continue;
      values += "    \"" + verb.name + " " + option->name + "\") words=\"";
      for (const auto& one : option->choices) values += (values.back() == '"' ? "" : " ") + one;
      values += "\" ;;\n";
    }
    options += "\" ;;\n";
  }
  return "# Completion of sonde for bash: source <(sonde completion bash)\n"
         "_sonde() {\n"
         "  local current=${COMP_WORDS[COMP_CWORD]} previous=${COMP_WORDS[COMP_CWORD-1]}\n"
         "  local verb= word words=\n"
         "  for word in \"${COMP_WORDS[@]:1:COMP_CWORD-1}\"; do\n"
         "    if [[ $word != -* ]]; then verb=$word; break; fi\n"
         "  done\n"
         "  if [[ -z $verb || $verb == help ]]; then\n"
         "    COMPREPLY=($(compgen -W \"" +
         names +
         "\" -- \"$current\"))\n"
         "    return\n"
         "  fi\n"
         "  case \"$verb $previous\" in\n"
         "    \"completion completion\") words=\"bash\" ;;\n" +
         values +
         "  esac\n"
         "  if [[ -z $words && $current != -* ]]; then\n"
         "    COMPREPLY=($(compgen -f -- \"$current\"))\n"
         "    return\n"
         "  fi\n"
         "  [[ -n $words ]] || case $verb in\n" +
         options +
         "  esac\n"
         "  COMPREPLY=($(compgen -W \"$words\" -- \"$current\"))\n"
         "}\n"
         "complete -o filenames -F _sonde sonde\n";
}

Result<std::string> with_tables(const std::string& page) {
  std::string text;
  std::istringstream lines(page);
  for (std::string line; std::getline(lines, line);) {
    text += line + "\n";
    if (!line.starts_with("<!-- options") && !line.starts_with("<!-- keys of")) continue;
    const auto table = generated_table(line);
    if (!table) return table.error();
    const std::string marker = line;
    while (std::getline(lines, line) && line != "<!-- end -->") {
    }
    if (line != "<!-- end -->") {
      return Error{ErrorCode::kMalformedData,
                   "expected <!-- end --> after " + marker + ", found the end of the page"};
    }
    text += "\n" + *table + "\n" + line + "\n";
  }
  return text;
}

}  // namespace nav::app
