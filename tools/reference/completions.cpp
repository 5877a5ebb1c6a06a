#include "completions.hpp"

#include <algorithm>

namespace reference {
namespace {

std::string joined(const std::vector<std::string>& words) {
    std::string all;
    for (const std::string& word : words) all += (all.empty() ? "" : " ") + word;
    return all;
}

/// `text` in single quotation marks, for bash and zsh.
std::string quoted(std::string_view text) {
    std::string out = "'";
    for (const char c : text) out += c == '\'' ? std::string{"'\\''"} : std::string{c};
    return out + "'";
}

std::string first_clause(const std::string& help) { return help.substr(0, help.find_first_of(";:(")); }

// --- bash -------------------------------------------------------------------------------------------------------------

/// A call of the bash function that offers the values of the argument.
std::string offered_by_bash(const Program& program, const Argument& argument) {
    const std::string prefix = "_" + program.name + "_";
    switch (argument.offer()) {
    case Offer::words: return prefix + "words " + quoted(joined(argument.words()));
    case Offer::files: return prefix + "files";
    case Offer::messages: return prefix + "messages";
    case Offer::links: return prefix + "links";
    case Offer::ports: return prefix + "ports";
    case Offer::addresses: return prefix + "addresses";
    case Offer::link_names: return prefix + "link_names";
    case Offer::fields: return prefix + "fields";
    case Offer::devices: return prefix + "devices";
    case Offer::parameters: return prefix + "parameters";
    case Offer::commands: return prefix + "commands";
    case Offer::nothing: break;
    }
    return ":";
}

/// The lines of a case statement: the values after each option of a command.
std::string values_for_bash(const Program& program, const Command& command) {
    std::string text;
    for (const Argument& option : command.options)
        for (const std::string& name : option.names)
            if (!option.value.empty())
                text += "        " + quoted(command.name + " " + name) + ") " + offered_by_bash(program, option) +
                        "; return ;;\n";
    return text;
}

std::string options_of(const Command& command) {
    std::vector<std::string> all;
    for (const Argument& option : command.options) all.insert(all.end(), option.names.begin(), option.names.end());
    return joined(all);
}

std::string operands_for_bash(const Program& program, const Command& command) {
    std::string offer = ":", first;
    for (const Argument& operand : command.operands) {
        if (operand.offer() == Offer::words && first.empty() && command.operands.size() > 1)
            first = offered_by_bash(program, operand);
        else if (offer == ":" || operand.offer() == Offer::fields) offer = offered_by_bash(program, operand);
    }
    if (!first.empty()) offer = "if ((COMP_CWORD == 2)); then " + first + "; else " + offer + "; fi";
    return "        " + quoted(command.name) + ") options=" + quoted(options_of(command)) + "; operands=" + quoted(offer) +
           " ;;\n";
}

constexpr char bash_common[] = R"bash(_%P_words() { COMPREPLY=($(compgen -W "$1" -- "$cur")); }
_%P_files() { compopt -o filenames 2>/dev/null; COMPREPLY=($(compgen -f -- "$cur")); }
_%P_ports() { COMPREPLY=($(compgen -G "${cur:-/dev/}*" | grep -E '^/dev/(tty(USB|ACM|AMA|S)|serial|rfcomm)')); }
_%P_messages() { COMPREPLY=($(compgen -W '%MESSAGES%' -- "$cur")); }
# A colon ends a word of bash: behind one, the address of the link.
_%P_links() {
    local kind=$cur
    if [[ $cur == *:* ]]; then
        kind=${cur%%:*} cur=${cur#*:}
    elif [[ $prev == : ]]; then
        kind=${COMP_WORDS[COMP_CWORD - 2]}
    elif [[ $cur == : ]]; then
        kind=$prev cur=
    else
        compopt -o nospace 2>/dev/null
        _%P_words '%LINKS%'
        return
    fi
    case $kind in
        serial) _%P_ports ;;
        pty) _%P_files ;;
        can) COMPREPLY=($(compgen -W "$(ls /sys/class/net 2>/dev/null | grep can)" -- "$cur")) ;;
    esac
}
)bash";

// Calls the program as on the command line, with all words so far, because --control may be among them.
constexpr char bash_known[] =
    R"bash(_%P_known() { "${COMP_WORDS[0]}" __complete "$1" "${COMP_WORDS[@]:1}" 2>/dev/null | cut -f1; }
_%P_addresses() { _%P_words "%ADDRESSES% $(_%P_known devices)"; }
_%P_link_names() { _%P_words "$(_%P_known links)"; }
# A message, then its fields. '=' is a word of bash.
_%P_fields() {
    local known
    known=$("${COMP_WORDS[0]}" __complete fields "${COMP_WORDS[@]:1:COMP_CWORD}" 2>/dev/null) || { _%P_messages; return; }
    if [[ $cur == = ]]; then cur=; fi
    if [[ $known == *= ]]; then compopt -o nospace 2>/dev/null; fi
    _%P_words "$known"
}
_%P_devices() { _%P_words "$(_%P_known names)"; }
_%P_commands() { _%P_words "$(_%P_known commands)"; }
_%P_parameters() {
    case ${COMP_WORDS[2]} in
        get | set) _%P_words "$(_%P_known parameters)" ;;
        *) _%P_files ;;
    esac
}
)bash";

constexpr char zsh_known[] = R"zsh(_%P_known() {
    local -a known
    known=(${(f)"$(command $program __complete $1 $words 2>/dev/null)"})
    compadd -- ${known%%$'\t'*}
}
_%P_addresses() { compadd -- %ADDRESSES%; _%P_known devices; }
_%P_link_names() { _%P_known links; }
_%P_fields() {
    local -a known
    known=(${(f)"$(command $program __complete fields "${(@)words[1,CURRENT]}" 2>/dev/null)"})
    if [[ $words[CURRENT] == *=* ]]; then compadd -- $known; else compadd -S '' -- $known; fi
}
_%P_devices() { _%P_known names; }
_%P_commands() { _%P_known commands; }
_%P_parameters() {
    case $words[2] in
        get | set) _%P_known parameters ;;
        *) _files ;;
    esac
}
)zsh";

constexpr char fish_known[] = R"fish(function __%P_known
    set -l words (commandline -opc)
    command $words[1] __complete $argv[1] $words[2..-1] 2>/dev/null
end
function __%P_fields
    set -l words (commandline -opc)
    set -l now (commandline -ct)
    command $words[1] __complete fields $words[2..-1] "$now" 2>/dev/null
end
)fish";

void replace_all(std::string& text, std::string_view from, std::string_view to) {
    for (std::size_t at = 0; (at = text.find(from, at)) != text.npos; at += to.size()) text.replace(at, from.size(), to);
}

bool has_commands(const Program& program) { return !program.commands.front().name.empty(); }

// --- zsh --------------------------------------------------------------------------------------------------------------

/// `help`, escaped as a description for _arguments.
std::string described(const std::string& help) {
    std::string text = first_clause(help);
    for (const char c : {'[', ']'}) std::replace(text.begin(), text.end(), c, ' ');
    return text;
}

std::string offered_by_zsh(const Program& program, const Argument& argument) {
    switch (argument.offer()) {
    case Offer::words: return "(" + joined(argument.words()) + ")";
    case Offer::files: return "_files";
    case Offer::messages: return "_" + program.name + "_messages";
    case Offer::links: return "_" + program.name + "_links";
    case Offer::ports: return "_files -g \"/dev/tty*\"";
    case Offer::addresses: return "_" + program.name + "_addresses";
    case Offer::link_names: return "_" + program.name + "_link_names";
    case Offer::fields: return "_" + program.name + "_fields";
    case Offer::devices: return "_" + program.name + "_devices";
    case Offer::parameters: return "_" + program.name + "_parameters";
    case Offer::commands: return "_" + program.name + "_commands";
    case Offer::nothing: break;
    }
    return "";
}

/// The arguments of _arguments for a command.
std::string specs_for_zsh(const Program& program, const Command& command) {
    std::string text;
    const auto add = [&](const std::string& spec) { text += " \\\n            " + quoted(spec); };
    for (const Argument& option : command.options)
        for (const std::string& name : option.names) {
            const std::string value = option.value.empty() ? "" : ":value:" + offered_by_zsh(program, option);
            add((option.is_repeated() ? "*" : "") + name + "[" + described(option.help) + "]" + value);
        }
    for (std::size_t i = 0; i < command.operands.size(); ++i)
        add((i + 1 == command.operands.size() ? "*" : std::to_string(i + 1)) +
            ":operand:" + offered_by_zsh(program, command.operands[i]));
    return text;
}

// --- fish -------------------------------------------------------------------------------------------------------------

std::string quoted_for_fish(std::string_view text) {
    std::string out = "'";
    for (const char c : text) out += (c == '\'' || c == '\\' ? "\\" : "") + std::string{c};
    return out + "'";
}

std::string offered_by_fish(const Argument& argument) {
    switch (argument.offer()) {
    case Offer::words: return " -x -a " + quoted_for_fish(joined(argument.words()));
    case Offer::files: return " -r -F";
    case Offer::messages: return " -x -a " + quoted_for_fish(joined(message_names()));
    case Offer::links: return " -x -a " + quoted_for_fish(joined(link_prefixes()));
    case Offer::ports: return " -x -a '(__fish_complete_suffix /dev/tty)'";
    case Offer::addresses: return " -x -a " + quoted_for_fish(joined(address_names()) + " (__anoctl_known devices)");
    case Offer::link_names: return " -x -a '(__anoctl_known links)'";
    case Offer::fields: return " -x -a '(__anoctl_fields)'";
    case Offer::devices: return " -x -a '(__anoctl_known names)'";
    case Offer::parameters: return " -F -a '(__anoctl_known parameters)'";
    case Offer::commands: return " -x -a '(__anoctl_known commands)'";
    case Offer::nothing: break;
    }
    return " -x";
}

std::string for_fish(const Program& program, const Command& command) {
    const std::string start = "complete -c " + program.name +
                              (command.name.empty() ? "" : " -n '__fish_seen_subcommand_from " + command.name + "'");
    std::string text;
    for (const Argument& option : command.options) {
        text += start;
        for (const std::string& name : option.names)
            text += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
        text += (option.value.empty() ? "" : offered_by_fish(option)) + " -d " + quoted_for_fish(first_clause(option.help)) +
                "\n";
    }
    for (const Argument& operand : command.operands)
        if (operand.offer() != Offer::nothing) {
            const std::string offer = offered_by_fish(operand);
            text += start + (operand.offer() == Offer::files ? " -F" : offer.substr(3)) +
                    "\n";    // operands have neither -r nor -x
        }
    return text;
}

}    // namespace

std::string bash_completion(const Program& program) {
    std::string text = "# Completions of bash for " + program.name + ". Generated from its tables of options and commands.\n";
    std::string common = bash_common;
    replace_all(common, "%MESSAGES%", joined(message_names()));
    replace_all(common, "%LINKS%", joined(link_prefixes()));
    if (has_commands(program)) common += bash_known;
    replace_all(common, "%ADDRESSES%", joined(address_names()));
    text += common +
            "_%P() {\n    local cur=${COMP_WORDS[COMP_CWORD]} prev=${COMP_WORDS[COMP_CWORD - 1]} command= options= operands=:\n"
            "    COMPREPLY=()\n";
    std::string names, values, operands;
    for (const Command& command : program.commands) {
        names += (names.empty() ? "" : " ") + command.name;
        values += values_for_bash(program, command);
        operands += operands_for_bash(program, command);
    }
    if (has_commands(program))
        text += "    if ((COMP_CWORD == 1)); then _%P_words '" + names +
                " help --help --version'; return; fi\n    command=${COMP_WORDS[1]}\n"
                "    if [[ $command == help ]]; then _%P_words '" +
                names + "'; return; fi\n";
    text += "    case \"$command $prev\" in\n" + values + "    esac\n    case $command in\n" + operands + "    esac\n" +
            "    if [[ $cur == -* ]]; then _%P_words \"$options\"; else eval \"$operands\"; fi\n}\ncomplete -F _%P %P\n";
    replace_all(text, "%P", program.name);
    return text;
}

std::string zsh_completion(const Program& program) {
    std::string text = "#compdef %P\n# Completions of zsh for %P. Generated from its tables of options and commands.\n";
    text += "_%P_messages() { compadd -- " + joined(message_names()) + "; }\n";
    if (has_commands(program)) text += zsh_known;
    replace_all(text, "%ADDRESSES%", joined(address_names()));
    text +=
        "_%P_links() {\n    if compset -P 'serial:'; then _files -g '/dev/tty*'; elif compset -P 'pty:'; then _files\n"
        "    elif ! compset -P '*:'; then compadd -S '' -- " +
        joined(link_prefixes()) + "; fi\n}\n_%P() {\n";
    if (!has_commands(program)) {
        text += "    _arguments" + specs_for_zsh(program, program.commands.front()) + "\n}\n";
    } else {
        text += "    local -a commands\n    commands=(\n";
        for (const Command& command : program.commands)
            text += "        " + quoted(command.name + ":" + described(command.help)) + "\n";
        text +=
            "    )\n    if ((CURRENT == 2)); then _describe command commands; return; fi\n"
            "    local program=$words[1] command=$words[2]\n    shift words\n    ((CURRENT--))\n    case $command in\n";
        for (const Command& command : program.commands)
            text += "        " + command.name + ") _arguments" + specs_for_zsh(program, command) + " ;;\n";
        text += "    esac\n}\n";
    }
    text += "_%P \"$@\"\n";
    replace_all(text, "%P", program.name);
    return text;
}

std::string fish_completion(const Program& program) {
    std::string text = "# Completions of fish for " + program.name +
                       ". Generated from its tables of options and commands.\ncomplete -c " + program.name + " -f\n";
    if (has_commands(program)) text += fish_known;
    replace_all(text, "%P", program.name);
    if (has_commands(program))
        for (const Command& command : program.commands)
            text += "complete -c " + program.name + " -n __fish_use_subcommand -a " + command.name + " -d " +
                    quoted_for_fish(first_clause(command.help)) + "\n";
    for (const Command& command : program.commands) text += for_fish(program, command);
    return text;
}

}    // namespace reference
