#include "render/cmd/manual.h"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <array>
#include <string_view>
#include <utility>
#include <vector>

namespace cmd {

namespace {

/// Words that may stand behind an option.
constexpr std::array<std::pair<std::string_view, std::string_view>, 5> option_values{{
    {"--preset", "preview standard accurate draft final"},
    {"--color-by", "look material body speed contacts impulse"},
    {"--show", "none title time contacts energy points normals impulses trails contact_paths plots"},
    {"--fail-on", "identical noise changed"},
    {"--format", "y4m rgb24"},
}};

/// Text for roff: a backslash, and a point or quote at the start of a line, are commands there.
std::string roff(const std::string& text) {
    std::string escaped;
    for (const char c : text) {
        const bool starts_line = escaped.empty() || escaped.back() == '\n';
        if (c == '\\') {
            escaped += "\\e";
        } else if (c == '-') {
            escaped += "\\-";
        } else {
            escaped += (starts_line && (c == '.' || c == '\'') ? "\\&" : "") + std::string(1, c);
        }
    }
    return escaped;
}

/// "--out DIR", "SCENE".
std::string synopsis(const CLI::Option& option) {
    const std::string name = option.get_name(option.get_positional(), true);
    const std::string type = option.get_positional() ? std::string() : option.get_type_name();
    return type.empty() ? name : name + " " + type;
}

std::string options_of(const CLI::App& app) {
    std::string text;
    for (const CLI::Option* option : app.get_options()) {
        text += fmt::format(".TP\n.B {}\n{}\n", roff(synopsis(*option)), roff(option->get_description()));
    }
    return text;
}

std::vector<const CLI::App*> verbs_of(const CLI::App& app) {
    return app.get_subcommands([](const CLI::App*) { return true; });
}

std::string section_of(const CLI::App& verb, const std::string& name) {
    return fmt::format(".SS {}\n{}\n{}", roff(name), roff(verb.get_description()), options_of(verb));
}

/// Long names of the options, separated by spaces.
std::string words_of(const CLI::App& app) {
    std::string words;
    for (const CLI::Option* option : app.get_options()) {
        for (const std::string& name : option->get_lnames()) {
            words += (words.empty() ? "--" : " --") + name;
        }
    }
    return words;
}

} // namespace

std::string man_page(const CLI::App& app) {
    std::string text = fmt::format(
        ".TH TUMBLE 1 \"\" \"tumble {}\"\n.SH NAME\ntumble \\- rigid bodies in contact, and films of "
        "them\n.SH SYNOPSIS\n.B tumble\n.I VERB\n[options]\n.SH DESCRIPTION\n{}\n.SH VERBS\n",
        TUMBLE_VERSION, roff(app.get_description()));
    for (const CLI::App* verb : verbs_of(app)) {
        text += section_of(*verb, "tumble " + verb->get_name());
        for (const CLI::App* below : verbs_of(*verb)) {
            text += section_of(*below, fmt::format("tumble {} {}", verb->get_name(), below->get_name()));
        }
    }
    text += ".SH OPTIONS\n" + options_of(app);
    const std::string footer = app.get_footer(); // "Examples:", then "Exit status:"
    const std::size_t status = footer.find("Exit status:");
    const auto after_head = [](const std::string& part) { return part.substr(part.find('\n') + 1); };
    return text + fmt::format(".SH EXAMPLES\n.nf\n{}.fi\n.SH EXIT STATUS\n.nf\n{}.fi\n",
                              roff(after_head(footer.substr(0, status))), roff(after_head(footer.substr(status))));
}

std::string bash_completion(const CLI::App& app) {
    std::string verbs;
    std::string cases;
    for (const CLI::App* verb : verbs_of(app)) {
        verbs += (verbs.empty() ? "" : " ") + verb->get_name();
        std::string words = words_of(*verb);
        for (const CLI::App* below : verbs_of(*verb)) {
            words = below->get_name() + " " + words_of(*below) + " " + words;
        }
        words = verb->get_name() == "help" ? "$verbs" : words;
        cases += fmt::format("        {}) words=\"{}\" ;;\n", verb->get_name(), words);
    }
    std::string values;
    for (const auto& [option, words] : option_values) {
        values += fmt::format("        {}) words=\"{}\" ;;\n", option, words);
    }
    return fmt::format(
        R"(# bash completion of tumble; zsh reads it after: autoload -U bashcompinit && bashcompinit
_tumble() {{
    local verbs="{}"
    local words="$verbs {}"
    [ "$COMP_CWORD" -gt 1 ] && case ${{COMP_WORDS[1]}} in
{}        esac
    local values=1
    case ${{COMP_WORDS[COMP_CWORD-1]}} in
{}        *) values=0 ;;
    esac
    [[ " tumble baseline help " == *" ${{COMP_WORDS[COMP_CWORD-1]}} "* ]] && values=1
    if [ "$COMP_CWORD" -eq 1 ] || [ "$values" -eq 1 ] || [[ ${{COMP_WORDS[COMP_CWORD]}} == -* ]]; then
        COMPREPLY=($(compgen -W "$words" -- "${{COMP_WORDS[COMP_CWORD]}}"))
    fi
}}
complete -o default -F _tumble tumble
)",
        verbs, words_of(app), cases, values);
}

} // namespace cmd
